// A voxel's value with the mean correction of its rays: x = clamp(x + c factor / 2^LAMBDA), factor = λ / weight from a table.
//
// Combinational, as FixedPoint::corrected. Values may have a sign (`signedValue`), corrections have one.
module corrected #(
    parameter int ENERGY = 16,
    parameter int SCALAR = 16,
    parameter int FACTOR = 32,
    parameter int LAMBDA = 19,  // fraction bits of λ
    parameter int ROUNDING = 1
) (
    input logic signedValue,
    input logic [LAMBDA-1:0] random,
    input logic [SCALAR-1:0] value,
    input logic [SCALAR-1:0] lowest,
    input logic [SCALAR-1:0] highest,
    input logic [ENERGY-1:0] correction,
    input logic [FACTOR-1:0] factor,
    output logic [SCALAR-1:0] result
);
    localparam int PRODUCT = ENERGY + FACTOR + 2;
    localparam int CHANGE = PRODUCT - LAMBDA;
    localparam int WIDE = (CHANGE > SCALAR + 1 ? CHANGE : SCALAR + 1) + 1;

    function automatic signed [WIDE-1:0] extended(input [SCALAR-1:0] word);
        extended = {{(WIDE - SCALAR) {signedValue & word[SCALAR-1]}}, word};
    endfunction

    logic signed [PRODUCT-1:0] wideCorrection, wideFactor, product;
    logic [CHANGE-1:0] change;
    logic signed [WIDE-1:0] sum;
    assign wideCorrection = {{(FACTOR + 2) {correction[ENERGY-1]}}, correction};
    assign wideFactor = {{(ENERGY + 2) {1'b0}}, factor};
    assign product = wideCorrection * wideFactor;
    rounded #(.WIDTH(PRODUCT), .SHIFT(LAMBDA), .ROUNDING(ROUNDING)) round (.value(product), .random, .result(change));
    assign sum = extended(value) + {{(WIDE - CHANGE) {change[CHANGE-1]}}, change};

    always_comb begin
        result = sum[SCALAR-1:0];
        if (sum < extended(lowest)) result = lowest;
        else if (sum > extended(highest)) result = highest;
    end
endmodule
