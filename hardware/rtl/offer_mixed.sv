// Interpolates two offers, {part, given}: a part of 1, and a power that may have a sign.
//
// Combinational.
module offer_mixed #(
    parameter int ENERGY = 16,
    parameter int PART = 12,
    parameter int WEIGHT = 12,
    parameter int ROUNDING = 1
) (
    input logic [PART+ENERGY+1:0] low,
    input logic [PART+ENERGY+1:0] high,
    input logic [WEIGHT:0] weightHigh,
    input logic [2*WEIGHT-1:0] random,
    output logic [PART+ENERGY+1:0] result
);
    /* verilator lint_off UNUSED */
    logic [PART+1:0] part;  // its leading bit is 0
    /* verilator lint_on UNUSED */
    logic [ENERGY:0] given;

    interpolated #(.WIDTH(PART + 2), .WEIGHT(WEIGHT), .ROUNDING(ROUNDING)) ofParts (
        .low({1'b0, low[PART+ENERGY+1:ENERGY+1]}), .high({1'b0, high[PART+ENERGY+1:ENERGY+1]}), .weightHigh,
        .random(random[WEIGHT-1:0]), .result(part));
    interpolated #(.WIDTH(ENERGY + 1), .WEIGHT(WEIGHT), .ROUNDING(ROUNDING)) ofGiven (
        .low(low[ENERGY:0]), .high(high[ENERGY:0]), .weightHigh,
        .random(random[2*WEIGHT-1:WEIGHT]), .result(given));
    assign result = {part[PART:0], given};
endmodule
