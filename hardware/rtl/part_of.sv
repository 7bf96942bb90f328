// The part of a power, as FixedPoint::partOf: power part / 2^PART, rounded.
//
// Combinational. `part` is at most 1, that is 2^PART: the result needs no more bits than the power.
module part_of #(
    parameter int POWER = 16,
    parameter int PART = 12,
    parameter int ROUNDING = 1
) (
    input logic [POWER-1:0] power,
    input logic [PART:0] part,
    input logic [PART-1:0] random,
    output logic [POWER-1:0] result
);
    localparam int PRODUCT = POWER + PART + 1;
    logic [PRODUCT-1:0] product;
    /* verilator lint_off UNUSED */
    logic [POWER:0] whole;  // its leading bit is 0
    /* verilator lint_on UNUSED */

    assign product = {{(PART + 1) {1'b0}}, power} * {{POWER{1'b0}}, part};
    rounded #(.WIDTH(PRODUCT), .SHIFT(PART), .ROUNDING(ROUNDING)) round (
        .value(product), .random, .result(whole));
    assign result = whole[POWER-1:0];
endmodule
