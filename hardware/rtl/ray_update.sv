// Ray update: a ray and what its voxels have for it.
//
// Holds      nothing.
// Per cycle  in: the ray that ends here, and the offers interpolated at it; out: the changed ray. Where it belongs is the
//            address generator's, as it is where there is none (the first voxels of rows and slices).
// Latency    one cycle.
//
//     illuminating   e += out - e α, which saturates        backprojecting   unchanged
module ray_update #(
    parameter int ENERGY = 16,
    parameter int PART = 12,
    parameter int WEIGHT = 12,
    parameter int ROUNDING = 1
) (
    input logic clk,
    input logic valid,
    input logic backproject,
    input logic [PART-1:0] random,
    input logic [ENERGY+WEIGHT:0] ending,
    input logic [PART+ENERGY+1:0] offer,
    output logic [ENERGY+WEIGHT:0] ray
);
    logic [ENERGY-1:0] power, taken, after;
    logic [ENERGY:0] sum;
    assign power = ending[ENERGY+WEIGHT:WEIGHT+1];
    part_of #(.POWER(ENERGY), .PART(PART), .ROUNDING(ROUNDING)) takes (
        .power, .part(offer[PART+ENERGY+1:ENERGY+1]), .random, .result(taken));
    assign sum = {1'b0, power} - {1'b0, taken} + offer[ENERGY:0];
    assign after = sum[ENERGY] ? '1 : sum[ENERGY-1:0];
    always_ff @(posedge clk) if (valid) ray <= {backproject ? power : after, ending[WEIGHT:0]};
endmodule
