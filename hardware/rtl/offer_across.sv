// Voxels to rays, along the beam.
//
// Holds      the last partial beam's offer, for the pipeline on whose right the beam goes on.
// Per cycle  in: what a voxel has for rays; out: that interpolated along u at the ray one voxel back.
// Latency    one cycle. Neighbour: an offer from the pipeline before.
module offer_across #(
    parameter int ENERGY = 16,
    parameter int PART = 12,
    parameter int WEIGHT = 12,
    parameter int ROUNDING = 1
) (
    input logic clk,
    input logic valid,
    input logic begins,
    input logic handsKept,
    input logic linear,
    input logic [WEIGHT:0] uHigh,
    input logic [2*WEIGHT-1:0] random,
    input logic [PART+ENERGY+1:0] offer,
    input logic [PART+ENERGY+1:0] fromLeft,
    output logic [PART+ENERGY+1:0] onward,
    output logic [PART+ENERGY+1:0] across
);
    logic [PART+ENERGY+1:0] left, mixed;
    left_neighbour #(.BITS(PART + ENERGY + 2)) neighbour (
        .clk, .valid, .begins, .handsKept, .own(offer), .fromLeft, .left, .onward);
    offer_mixed #(.ENERGY(ENERGY), .PART(PART), .WEIGHT(WEIGHT), .ROUNDING(ROUNDING)) mix (
        .low(left), .high(offer), .weightHigh(uHigh), .random, .result(mixed));
    always_ff @(posedge clk) if (valid) across <= linear ? mixed : offer;
endmodule
