// Interpolates two rays, {value, weight}: illuminating, values are powers; backprojecting, corrections with a sign.
//
// Combinational.
module ray_mixed #(
    parameter int ENERGY = 16,
    parameter int WEIGHT = 12,
    parameter int ROUNDING = 1
) (
    input logic backproject,
    input logic [ENERGY+WEIGHT:0] low,
    input logic [ENERGY+WEIGHT:0] high,
    input logic [WEIGHT:0] weightHigh,
    input logic [2*WEIGHT-1:0] random,
    output logic [ENERGY+WEIGHT:0] result
);
    localparam int RAY = ENERGY + WEIGHT + 1;
    logic [ENERGY:0] lowValue, highValue;
    /* verilator lint_off UNUSED */
    logic [ENERGY:0] value;      // leading bits: of the sign
    logic [WEIGHT+1:0] weight;
    /* verilator lint_on UNUSED */

    assign lowValue = {backproject & low[RAY-1], low[RAY-1:WEIGHT+1]};
    assign highValue = {backproject & high[RAY-1], high[RAY-1:WEIGHT+1]};
    interpolated #(.WIDTH(ENERGY + 1), .WEIGHT(WEIGHT), .ROUNDING(ROUNDING)) ofValues (
        .low(lowValue), .high(highValue), .weightHigh, .random(random[WEIGHT-1:0]), .result(value));
    interpolated #(.WIDTH(WEIGHT + 2), .WEIGHT(WEIGHT), .ROUNDING(ROUNDING)) ofWeights (
        .low({1'b0, low[WEIGHT:0]}), .high({1'b0, high[WEIGHT:0]}), .weightHigh,
        .random(random[2*WEIGHT-1:WEIGHT]), .result(weight));
    assign result = {value[ENERGY-1:0], weight[WEIGHT:0]};
endmodule
