// Voxels to rays, from beam to beam.
//
// Holds      the beam buffer of voxels: the last beam's interpolated offers.
// Per cycle  in: offers interpolated along u; out: the offers interpolated at the ray that ends here, a voxel back along u
//            and v.
// Latency    one cycle. Neighbour: the beam before, from the pipeline before.
module offer_along #(
    parameter int ENERGY = 16,
    parameter int PART = 12,
    parameter int WEIGHT = 12,
    parameter int ROUNDING = 1,
    parameter int PARTS = 16,
    parameter int ADDRESS = 4
) (
    input logic clk,
    input logic valid,
    input logic firstRow,
    input logic linear,
    input logic [ADDRESS-1:0] part,
    input logic [ADDRESS-1:0] nextPart,
    input logic [WEIGHT:0] vHigh,
    input logic [2*WEIGHT-1:0] random,
    input logic [PART+ENERGY+1:0] across,
    input logic [PART+ENERGY+1:0] fromLeft,
    output logic [PART+ENERGY+1:0] onward,
    output logic [PART+ENERGY+1:0] along
);
    logic [PART+ENERGY+1:0] beamBefore, mixed;
    beam_buffer #(.BITS(PART + ENERGY + 2), .PARTS(PARTS), .ADDRESS(ADDRESS)) buffer (
        .clk, .valid, .firstRow, .part, .nextPart, .own(across), .fromLeft, .beamBefore, .onward);
    offer_mixed #(.ENERGY(ENERGY), .PART(PART), .WEIGHT(WEIGHT), .ROUNDING(ROUNDING)) mix (
        .low(beamBefore), .high(across), .weightHigh(vHigh), .random, .result(mixed));
    always_ff @(posedge clk) if (valid) along <= linear ? mixed : across;
endmodule
