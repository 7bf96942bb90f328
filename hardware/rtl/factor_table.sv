// λ / weight for every weight that a voxel's rays can have: no divider is needed.
//
// Holds      an entry for each weight in [0, 2^WEIGHT], loaded by the host for a pass, since λ is the pass's:
//            ((λ << WEIGHT) + weight / 2) / weight; that of weight 0 is never used.
// Per cycle  in: the weight of the beam that comes to the exchange in the next cycle; out: its factor.
// Latency    one cycle.
module factor_table #(
    parameter int WEIGHT = 12,
    parameter int FACTOR = 32
) (
    input logic clk,
    input logic loads,
    input logic [WEIGHT:0] loadAt,
    input logic [FACTOR-1:0] entry,
    input logic [WEIGHT:0] weight,
    output logic [FACTOR-1:0] factor
);
    logic [FACTOR-1:0] entries[0:2**WEIGHT];
    always_ff @(posedge clk) begin
        if (loads) entries[loadAt] <= entry;
        factor <= entries[weight];
    end
endmodule
