// One pipeline's part of the reverse path: a ray is resampled to a voxel, both change each other, what the voxel has for
// rays is resampled to the ray that ends there.
//
//     ray -> ray_across -> ray_along -> exchange -> offer_across -> offer_along -> ray_update -> ray
//                            voxel ->      |                                          |
//                                          +-> voxel          ending ray, delayed ->  +
//
// Holds      the control word and a valid bit of each stage's partial beam.
// Per cycle  in: control word, a ray, the voxel whose position it has; out: a changed voxel, and a changed ray.
// Latency    three cycles for a voxel, six for a ray. Neighbours: four words from the pipeline before, four to the next.
//
// All pipelines get the same control word, but for `begins` and `handsKept` (left_neighbour.sv). What is below "pass" is
// constant while beams are under way. Words that are not valid mean nothing.
module reverse_lane #(
    parameter int ENERGY = 16,          // powers and corrections of rays, powers of voxels
    parameter int PART = 12,            // fraction of opacities, gains and what is shot
    parameter int WEIGHT = 12,          // fraction of interpolation weights
    parameter int SUM = 40,             // deposits
    parameter int SCALAR = 16,          // the value that is reconstructed
    parameter int FACTOR = 20 + WEIGHT, // λ / weight, with LAMBDA fraction bits
    parameter int ROUNDING = 1,         // rounded.sv
    parameter int PARTS = 16,           // partial beams of a beam, at most
    parameter int ADDRESS = PARTS > 1 ? $clog2(PARTS) : 1,
    parameter int RANDOM = 32,          // of a random word; more are zeros
    // Fraction bits of λ, as FixedPoint::relaxationBits has them.
    localparam int FINE = 19 + ENERGY - SCALAR, LAMBDA = FINE > 8 ? FINE : 8,
    localparam int RAY = ENERGY + WEIGHT + 1,  // {value, weight}
    localparam int OFFER = PART + ENERGY + 2  // {part, given}, given with a sign
) (
    input logic clk,
    input logic reset,
    // Control word.
    input logic valid,
    input logic begins,
    input logic handsKept,
    input logic firstRow,
    input logic [ADDRESS-1:0] part,
    input logic [WEIGHT:0] uHigh,
    input logic [WEIGHT:0] vHigh,
    // Pass.
    input logic linear,
    input logic backproject,
    input logic inject,
    input logic group,
    input logic settle,
    input logic signedValue,
    input logic [SCALAR-1:0] lowest,
    input logic [SCALAR-1:0] highest,
    input logic factorLoads,
    input logic [WEIGHT:0] factorAt,
    input logic [FACTOR-1:0] factorEntry,
    // Stochastic rounding: a word for each that is made in a cycle, of ray_across (2), ray_along (2), exchange (3),
    // offer_across (2), offer_along (2) and ray_update.
    /* verilator lint_off UNUSED */
    input logic [12*RANDOM-1:0] random,
    /* verilator lint_on UNUSED */
    input logic [RAY-1:0] ray,
    // Voxel.
    input logic [PART:0] opacity,
    input logic [PART:0] shot,
    input logic [PART:0] gain,
    input logic [ENERGY-1:0] source,
    input logic [ENERGY-1:0] unshot,
    input logic [ENERGY:0] fresh,
    input logic [SUM-1:0] deposit,
    input logic [SCALAR-1:0] scalar,
    // Links of the ring.
    input logic [RAY-1:0] rayFromLeft,
    output logic [RAY-1:0] rayOnward,
    input logic [2*RAY-1:0] raysFromLeft,
    output logic [2*RAY-1:0] raysOnward,
    input logic [OFFER-1:0] offerFromLeft,
    output logic [OFFER-1:0] offerOnward,
    input logic [OFFER-1:0] offersFromLeft,
    output logic [OFFER-1:0] offersOnward,
    output logic voxelValid,
    output logic [ENERGY-1:0] unshotOut,
    output logic [ENERGY:0] freshOut,
    output logic [SUM-1:0] depositOut,
    output logic [SCALAR-1:0] scalarOut,
    output logic rayValid,
    output logic [RAY-1:0] rayOut
);
    localparam int STAGES = 6;
    localparam int U = WEIGHT + 3, V = WEIGHT + 2 + ADDRESS;  // what stages along u need, and along v
    localparam int VOXEL = 3 * (PART + 1) + 3 * ENERGY + 1 + SUM + SCALAR;

    logic [STAGES:1] valids;  // of the beam that has left stage i
    always_ff @(posedge clk) valids <= reset ? '0 : {valids[STAGES-1:1], valid};
    assign voxelValid = valids[3];
    assign rayValid = valids[6];

    logic [U-1:0] u1, u2, u3;
    logic [V-1:0] v1, v2, v3, v4;
    always_ff @(posedge clk) begin
        {u3, u2, u1} <= {u2, u1, begins, handsKept, uHigh};
        {v4, v3, v2, v1} <= {v3, v2, v1, firstRow, vHigh, part};
    end

    logic [RAY-1:0] across, endsAcross, along, endsAlong, endsHere, ending;
    logic [WEIGHT:0] weight;
    logic [FACTOR-1:0] factor;
    logic [OFFER-1:0] offer, offerAcross, offerAlong;
    logic [VOXEL-1:0] waited;

    ray_across #(.ENERGY(ENERGY), .WEIGHT(WEIGHT), .ROUNDING(ROUNDING)) rayAcross (
        .clk, .valid, .begins, .handsKept, .linear, .backproject, .uHigh,
        .random({random[RANDOM+:WEIGHT], random[0+:WEIGHT]}), .ray, .fromLeft(rayFromLeft), .onward(rayOnward),
        .across, .ending(endsAcross));

    ray_along #(.ENERGY(ENERGY), .WEIGHT(WEIGHT), .ROUNDING(ROUNDING), .PARTS(PARTS), .ADDRESS(ADDRESS)) rayAlong (
        .clk, .valid(valids[1]), .firstRow(v1[V-1]), .linear, .backproject, .part(v1[ADDRESS-1:0]), .nextPart(part),
        .vHigh(v1[ADDRESS+:WEIGHT+1]), .random({random[3*RANDOM+:WEIGHT], random[2*RANDOM+:WEIGHT]}), .across,
        .endsAcross, .fromLeft(raysFromLeft), .onward(raysOnward), .along, .ending(endsAlong), .weight);

    factor_table #(.WEIGHT(WEIGHT), .FACTOR(FACTOR)) factors (
        .clk, .loads(factorLoads), .loadAt(factorAt), .entry(factorEntry), .weight, .factor);

    delay_line #(.BITS(VOXEL), .CYCLES(2)) voxelWaits (
        .clk, .in({opacity, shot, gain, source, unshot, fresh, deposit, scalar}), .out(waited));

    localparam int DEPOSIT = SCALAR, FRESH = DEPOSIT + SUM, UNSHOT = FRESH + ENERGY + 1, SOURCE = UNSHOT + ENERGY,
        GAIN = SOURCE + ENERGY, SHOT = GAIN + PART + 1, OPACITY = SHOT + PART + 1;
    exchange #(.ENERGY(ENERGY), .PART(PART), .WEIGHT(WEIGHT), .SUM(SUM), .SCALAR(SCALAR), .FACTOR(FACTOR),
               .LAMBDA(LAMBDA), .RANDOM(RANDOM), .ROUNDING(ROUNDING)) exchanges (
        .clk, .valid(valids[2]), .linear, .backproject, .inject, .group, .settle, .signedValue, .lowest, .highest, .factor,
        .random(random[4*RANDOM+:3*RANDOM]), .along, .ending(endsAlong), .opacity(waited[OPACITY+:PART+1]),
        .shot(waited[SHOT+:PART+1]), .gain(waited[GAIN+:PART+1]), .source(waited[SOURCE+:ENERGY]),
        .unshot(waited[UNSHOT+:ENERGY]), .fresh(waited[FRESH+:ENERGY+1]), .deposit(waited[DEPOSIT+:SUM]),
        .scalar(waited[0+:SCALAR]), .unshotOut, .freshOut, .depositOut, .scalarOut, .offer, .endingOut(endsHere));

    offer_across #(.ENERGY(ENERGY), .PART(PART), .WEIGHT(WEIGHT), .ROUNDING(ROUNDING)) offersAcross (
        .clk, .valid(valids[3]), .begins(u3[U-1]), .handsKept(u3[U-2]), .linear, .uHigh(u3[WEIGHT:0]),
        .random({random[8*RANDOM+:WEIGHT], random[7*RANDOM+:WEIGHT]}), .offer, .fromLeft(offerFromLeft),
        .onward(offerOnward), .across(offerAcross));

    offer_along #(.ENERGY(ENERGY), .PART(PART), .WEIGHT(WEIGHT), .ROUNDING(ROUNDING), .PARTS(PARTS),
                  .ADDRESS(ADDRESS)) offersAlong (
        .clk, .valid(valids[4]), .firstRow(v4[V-1]), .linear, .part(v4[ADDRESS-1:0]), .nextPart(v3[ADDRESS-1:0]),
        .vHigh(v4[ADDRESS+:WEIGHT+1]), .random({random[10*RANDOM+:WEIGHT], random[9*RANDOM+:WEIGHT]}),
        .across(offerAcross), .fromLeft(offersFromLeft), .onward(offersOnward), .along(offerAlong));

    delay_line #(.BITS(RAY), .CYCLES(2)) endingWaits (.clk, .in(endsHere), .out(ending));

    ray_update #(.ENERGY(ENERGY), .PART(PART), .WEIGHT(WEIGHT), .ROUNDING(ROUNDING)) rayUpdate (
        .clk, .valid(valids[5]), .backproject, .random(random[11*RANDOM+:PART]), .ending, .offer(offerAlong),
        .ray(rayOut));
endmodule
