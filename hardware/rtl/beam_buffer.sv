// Beam buffer: the word of the voxel one beam up, which the pipeline before has.
//
// Holds      this pipeline's words of the last beam.
// Per cycle  in: this pipeline's word, and the last beam's from the pipeline before; out: the word one beam up, and this
//            pipeline's of the last beam for the next pipeline.
// Latency    none for the beam that is here; its address comes a cycle before it.
module beam_buffer #(
    parameter int BITS = 58,
    parameter int PARTS = 16,
    parameter int ADDRESS = 4
) (
    input logic clk,
    input logic valid,
    input logic firstRow,                // of a slice: there is nothing one beam up
    input logic [ADDRESS-1:0] part,      // of the beam that is here
    input logic [ADDRESS-1:0] nextPart,  // of the beam that comes in the next cycle
    input logic [BITS-1:0] own,
    input logic [BITS-1:0] fromLeft,
    output logic [BITS-1:0] beamBefore,
    output logic [BITS-1:0] onward
);
    beam_memory #(.BITS(BITS), .PARTS(PARTS), .ADDRESS(ADDRESS)) memory (
        .clk, .writes(valid), .writeAt(part), .in(own), .readAt(nextPart), .out(onward));
    assign beamBefore = firstRow ? '0 : fromLeft;
endmodule
