// Interpolates two words, as FixedPoint::mix does.
//
// Combinational; words have a sign. The weights of a pair add up to 1: one product is enough,
//     2^WEIGHT low + weightHigh (high - low)        weightHigh in [0, 2^WEIGHT]
module interpolated #(
    parameter int WIDTH = 17,
    parameter int WEIGHT = 12,
    parameter int ROUNDING = 1
) (
    input logic [WIDTH-1:0] low,
    input logic [WIDTH-1:0] high,
    input logic [WEIGHT:0] weightHigh,
    input logic [WEIGHT-1:0] random,
    output logic [WIDTH-1:0] result
);
    localparam int PRODUCT = WIDTH + WEIGHT + 2;
    logic [WIDTH:0] difference;
    logic signed [PRODUCT-1:0] factor, wide, scaled;
    logic [PRODUCT-1:0] sum;
    /* verilator lint_off UNUSED */
    logic [WIDTH+1:0] whole;  // its two leading bits are copies of the sign
    /* verilator lint_on UNUSED */

    assign difference = {high[WIDTH-1], high} - {low[WIDTH-1], low};
    assign factor = {{(WIDTH + 1) {1'b0}}, weightHigh};
    assign wide = {{(WEIGHT + 1) {difference[WIDTH]}}, difference};
    assign scaled = wide * factor;
    assign sum = {{2{low[WIDTH-1]}}, low, {WEIGHT{1'b0}}} + scaled;
    rounded #(.WIDTH(PRODUCT), .SHIFT(WEIGHT), .ROUNDING(ROUNDING)) round (.value(sum), .random, .result(whole));
    assign result = whole[WIDTH-1:0];
endmodule
