// Rays to voxels, from beam to beam.
//
// Holds      the beam buffer of rays: the last beam's interpolated rays and those that end.
// Per cycle  in: rays interpolated along u; out: the rays interpolated at the voxel, and the ray that ends there. The
//            weight goes to the exchange's table (factor_table.sv) a cycle before the ray goes to the exchange.
// Latency    one cycle. Neighbour: the beam before, from the pipeline before.
module ray_along #(
    parameter int ENERGY = 16,
    parameter int WEIGHT = 12,
    parameter int ROUNDING = 1,
    parameter int PARTS = 16,
    parameter int ADDRESS = 4
) (
    input logic clk,
    input logic valid,
    input logic firstRow,
    input logic linear,
    input logic backproject,
    input logic [ADDRESS-1:0] part,
    input logic [ADDRESS-1:0] nextPart,
    input logic [WEIGHT:0] vHigh,
    input logic [2*WEIGHT-1:0] random,
    input logic [ENERGY+WEIGHT:0] across,
    input logic [ENERGY+WEIGHT:0] endsAcross,
    input logic [2*(ENERGY+WEIGHT+1)-1:0] fromLeft,
    output logic [2*(ENERGY+WEIGHT+1)-1:0] onward,
    output logic [ENERGY+WEIGHT:0] along,
    output logic [ENERGY+WEIGHT:0] ending,
    output logic [WEIGHT:0] weight
);
    localparam int RAY = ENERGY + WEIGHT + 1;
    logic [RAY-1:0] acrossBefore, endingBefore, mixed, atVoxel;
    beam_buffer #(.BITS(2 * RAY), .PARTS(PARTS), .ADDRESS(ADDRESS)) buffer (
        .clk, .valid, .firstRow, .part, .nextPart, .own({across, endsAcross}), .fromLeft,
        .beamBefore({acrossBefore, endingBefore}), .onward);
    ray_mixed #(.ENERGY(ENERGY), .WEIGHT(WEIGHT), .ROUNDING(ROUNDING)) mix (
        .backproject, .low(across), .high(acrossBefore), .weightHigh(vHigh), .random, .result(mixed));
    assign atVoxel = linear ? mixed : across;
    assign weight = atVoxel[WEIGHT:0];
    always_ff @(posedge clk)
        if (valid) begin
            along <= atVoxel;
            ending <= linear ? endingBefore : endsAcross;
        end
endmodule
