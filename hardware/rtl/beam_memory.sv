// Memory of a beam buffer: one port to read, one to write.
//
// Holds      a word for each partial beam of a beam.
// Per cycle  in: a word to write, an address to read; out: the word that was read.
// Latency    one cycle. What is written in the cycle in which it is read is what is read: beams of one part follow each
//            other without a cycle between.
module beam_memory #(
    parameter int BITS = 58,
    parameter int PARTS = 16,
    parameter int ADDRESS = 4
) (
    input logic clk,
    input logic writes,
    input logic [ADDRESS-1:0] writeAt,
    input logic [BITS-1:0] in,
    input logic [ADDRESS-1:0] readAt,
    output logic [BITS-1:0] out
);
    logic [BITS-1:0] words[0:PARTS-1];
    logic [BITS-1:0] read, written;
    logic sameWord;
    always_ff @(posedge clk) begin
        if (writes) words[writeAt] <= in;
        read <= words[readAt];
        written <= in;
        sameWord <= writes && writeAt == readAt;
    end
    assign out = sameWord ? written : read;
endmodule
