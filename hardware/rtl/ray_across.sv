// Rays to voxels, along the beam.
//
// Holds      the last partial beam's ray, for the pipeline on whose right the beam goes on.
// Per cycle  in: the ray above and below which the voxel lies; out: the rays interpolated along u at the voxel, and the
//            ray that is one voxel back along u, which the voxel finishes (ray_update.sv).
// Latency    one cycle. Neighbour: a ray from the pipeline before.
//
// A voxel x is above the ray of position x - 1 and below that of position x: it gets their parts high and low.
module ray_across #(
    parameter int ENERGY = 16,
    parameter int WEIGHT = 12,
    parameter int ROUNDING = 1
) (
    input logic clk,
    input logic valid,
    input logic begins,
    input logic handsKept,
    input logic linear,
    input logic backproject,
    input logic [WEIGHT:0] uHigh,
    input logic [2*WEIGHT-1:0] random,
    input logic [ENERGY+WEIGHT:0] ray,
    input logic [ENERGY+WEIGHT:0] fromLeft,
    output logic [ENERGY+WEIGHT:0] onward,
    output logic [ENERGY+WEIGHT:0] across,
    output logic [ENERGY+WEIGHT:0] ending
);
    localparam int RAY = ENERGY + WEIGHT + 1;
    logic [RAY-1:0] left, mixed;
    left_neighbour #(.BITS(RAY)) neighbour (.clk, .valid, .begins, .handsKept, .own(ray), .fromLeft, .left, .onward);
    ray_mixed #(.ENERGY(ENERGY), .WEIGHT(WEIGHT), .ROUNDING(ROUNDING)) mix (
        .backproject, .low(ray), .high(left), .weightHigh(uHigh), .random, .result(mixed));
    always_ff @(posedge clk)
        if (valid) begin
            across <= linear ? mixed : ray;
            ending <= linear ? left : ray;
        end
endmodule
