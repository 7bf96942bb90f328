// Exchange: what a voxel and the ray at it do to each other.
//
// Holds      nothing. The tables by scalar, opacity and the part that is shot, are looked up before: their codes come with
//            the voxel. That of factors by weight is beside (factor_table.sv).
// Per cycle  in: a voxel, and the ray interpolated at it; out: the changed voxel, what it has for rays, and the ray that
//            ends there as it came.
// Latency    one cycle.
//
// Backprojecting, a voxel takes part where its gain is not 0, and changes where a ray that counts is near.
module exchange #(
    parameter int ENERGY = 16,
    parameter int PART = 12,
    parameter int WEIGHT = 12,
    parameter int SUM = 40,
    parameter int SCALAR = 16,
    parameter int FACTOR = 32,
    parameter int LAMBDA = 19,
    parameter int RANDOM = 32,
    parameter int ROUNDING = 1
) (
    input logic clk,
    input logic valid,
    input logic linear,
    input logic backproject,
    input logic inject,
    input logic group,
    input logic settle,
    input logic signedValue,
    input logic [SCALAR-1:0] lowest,
    input logic [SCALAR-1:0] highest,
    input logic [FACTOR-1:0] factor,
    /* verilator lint_off UNUSED */
    input logic [3*RANDOM-1:0] random,
    /* verilator lint_on UNUSED */
    input logic [ENERGY+WEIGHT:0] along,
    input logic [ENERGY+WEIGHT:0] ending,
    input logic [PART:0] opacity,
    input logic [PART:0] shot,
    input logic [PART:0] gain,
    input logic [ENERGY-1:0] source,
    input logic [ENERGY-1:0] unshot,
    input logic [ENERGY:0] fresh,
    input logic [SUM-1:0] deposit,
    input logic [SCALAR-1:0] scalar,
    output logic [ENERGY-1:0] unshotOut,
    output logic [ENERGY:0] freshOut,
    output logic [SUM-1:0] depositOut,
    output logic [SCALAR-1:0] scalarOut,
    output logic [PART+ENERGY+1:0] offer,
    output logic [ENERGY+WEIGHT:0] endingOut
);
    logic [ENERGY-1:0] ray, in, out, unshotAfter;
    logic [PART+ENERGY+1:0] offered;
    logic [ENERGY:0] freshAfter;
    logic [SUM-1:0] depositAfter;
    logic [SCALAR-1:0] scalarAfter;
    logic changes;
    logic [LAMBDA-1:0] low;  // that is dropped of a correction, at random

    generate
        if (LAMBDA <= RANDOM) assign low = random[LAMBDA-1:0];
        else assign low = {random[RANDOM-1:0], {(LAMBDA - RANDOM) {1'b0}}};
    endgenerate

    assign ray = along[ENERGY+WEIGHT:WEIGHT+1];
    assign changes = gain != '0 && along[WEIGHT:0] != '0;
    illuminated #(.ENERGY(ENERGY), .PART(PART), .SUM(SUM), .ROUNDING(ROUNDING)) light (
        .inject, .group, .settle, .random({random[2*RANDOM+:PART], random[RANDOM+:PART], random[0+:PART]}), .ray,
        .opacity, .shot, .gain, .source, .unshot, .fresh, .deposit, .in, .out, .unshotAfter,
        .freshAfter, .depositAfter);
    corrected #(.ENERGY(ENERGY), .SCALAR(SCALAR), .FACTOR(FACTOR), .LAMBDA(LAMBDA),
                .ROUNDING(ROUNDING)) correct (
        .signedValue, .random(low), .value(scalar), .lowest, .highest, .correction(ray), .factor,
        .result(scalarAfter));

    // A ray that has its voxel for itself is told the change: what rounding took from one, the other has.
    assign offered = linear ? {opacity, 1'b0, out} : {{(PART + 1) {1'b0}}, {1'b0, out} - {1'b0, in}};

    always_ff @(posedge clk)
        if (valid) begin
            unshotOut <= backproject ? unshot : unshotAfter;
            freshOut <= backproject ? fresh : freshAfter;
            depositOut <= backproject ? deposit : depositAfter;
            scalarOut <= backproject && changes ? scalarAfter : scalar;
            offer <= backproject ? '0 : offered;
            endingOut <= ending;
        end
endmodule
