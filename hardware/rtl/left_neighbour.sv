// The word of the voxel one to the left along a beam.
//
// Holds      the last partial beam's word, for the pipeline on whose right the beam goes on.
// Per cycle  in: this pipeline's word, and what the pipeline before hands on; out: the word to the left, and what is
//            handed to the next pipeline.
// Latency    none: only what is kept is a register.
//
// One word goes over each link in a cycle. The pipeline before the one that has the partial beam's first voxel hands on
// what it kept; at the beginning of a beam there is nothing to the left.
module left_neighbour #(
    parameter int BITS = 29
) (
    input logic clk,
    input logic valid,
    input logic begins,     // this pipeline has the first voxel of a beam
    input logic handsKept,  // the next pipeline has the first voxel of the partial beam
    input logic [BITS-1:0] own,
    input logic [BITS-1:0] fromLeft,
    output logic [BITS-1:0] left,
    output logic [BITS-1:0] onward
);
    logic [BITS-1:0] kept;
    always_ff @(posedge clk) if (valid) kept <= own;
    assign onward = handsKept ? kept : own;
    assign left = begins ? '0 : fromLeft;
endmodule
