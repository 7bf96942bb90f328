// Pipelines' reverse_lane in a ring, for the test: words of 64 bits, so that rings of all widths look alike from C++.
module reverse_ring #(
    parameter int PIPELINES = 1,
    parameter int ENERGY = 16,
    parameter int PART = 12,
    parameter int WEIGHT = 12,
    parameter int SUM = 40,
    parameter int SCALAR = 16,
    parameter int FACTOR = 32,
    parameter int ROUNDING = 1,
    parameter int PARTS = 4
) (
    /* verilator lint_off UNUSED */
    input logic clk,
    input logic reset,
    input logic valid,
    input logic [31:0] first,  // pipeline of the beam's first voxel
    input logic [31:0] part,
    input logic [31:0] row,
    input logic [63:0] uHigh,
    input logic [63:0] vHigh,
    input logic linear,
    input logic backproject,
    input logic inject,
    input logic group,
    input logic settle,
    input logic signedValue,
    input logic [63:0] lowest,
    input logic [63:0] highest,
    input logic factorLoads,
    input logic [63:0] factorAt,
    input logic [63:0] factorEntry,
    input logic [31:0] random[12*PIPELINES],
    input logic [63:0] value[PIPELINES],
    input logic [63:0] weight[PIPELINES],
    input logic [63:0] opacity[PIPELINES],
    input logic [63:0] shot[PIPELINES],
    input logic [63:0] gain[PIPELINES],
    input logic [63:0] source[PIPELINES],
    input logic [63:0] unshot[PIPELINES],
    input logic [63:0] fresh[PIPELINES],
    input logic [63:0] deposit[PIPELINES],
    input logic [63:0] scalar[PIPELINES],
    /* verilator lint_on UNUSED */
    output logic [PIPELINES-1:0] voxelValid,
    output logic [63:0] unshotOut[PIPELINES],
    output logic [63:0] freshOut[PIPELINES],
    output logic [63:0] depositOut[PIPELINES],
    output logic [63:0] scalarOut[PIPELINES],
    output logic [PIPELINES-1:0] rayValid,
    output logic [63:0] valueOut[PIPELINES],
    output logic [63:0] weightOut[PIPELINES]
);
    localparam int RAY = ENERGY + WEIGHT + 1, OFFER = PART + ENERGY + 2;
    localparam int ADDRESS = PARTS > 1 ? $clog2(PARTS) : 1;

    logic [RAY-1:0] rayLink[PIPELINES];
    logic [2*RAY-1:0] raysLink[PIPELINES];
    logic [OFFER-1:0] offerLink[PIPELINES], offersLink[PIPELINES];

    for (genvar lane = 0; lane < PIPELINES; ++lane) begin : lanes
        localparam int LEFT = (lane + PIPELINES - 1) % PIPELINES, RIGHT = (lane + 1) % PIPELINES;
        logic [12*32-1:0] words;
        logic [RAY-1:0] ray;
        logic [ENERGY:0] freshAfter;
        logic [SCALAR-1:0] scalarAfter;
        for (genvar i = 0; i < 12; ++i) assign words[32*i+:32] = random[12*lane+i];
        reverse_lane #(.ENERGY(ENERGY), .PART(PART), .WEIGHT(WEIGHT), .SUM(SUM), .SCALAR(SCALAR), .FACTOR(FACTOR),
                       .ROUNDING(ROUNDING), .PARTS(PARTS)) pipeline (
            .clk, .reset, .valid, .begins(first == lane && part == 0), .handsKept(first == RIGHT),
            .firstRow(row == 0), .part(part[ADDRESS-1:0]), .uHigh(uHigh[WEIGHT:0]), .vHigh(vHigh[WEIGHT:0]), .linear,
            .backproject, .inject, .group, .settle, .signedValue, .lowest(lowest[SCALAR-1:0]),
            .highest(highest[SCALAR-1:0]), .factorLoads, .factorAt(factorAt[WEIGHT:0]),
            .factorEntry(factorEntry[FACTOR-1:0]), .random(words),
            .ray({value[lane][ENERGY-1:0], weight[lane][WEIGHT:0]}), .opacity(opacity[lane][PART:0]),
            .shot(shot[lane][PART:0]), .gain(gain[lane][PART:0]), .source(source[lane][ENERGY-1:0]),
            .unshot(unshot[lane][ENERGY-1:0]), .fresh(fresh[lane][ENERGY:0]), .deposit(deposit[lane][SUM-1:0]),
            .scalar(scalar[lane][SCALAR-1:0]), .rayFromLeft(rayLink[LEFT]), .rayOnward(rayLink[lane]),
            .raysFromLeft(raysLink[LEFT]), .raysOnward(raysLink[lane]), .offerFromLeft(offerLink[LEFT]),
            .offerOnward(offerLink[lane]), .offersFromLeft(offersLink[LEFT]), .offersOnward(offersLink[lane]),
            .voxelValid(voxelValid[lane]), .unshotOut(unshotOut[lane][ENERGY-1:0]), .freshOut(freshAfter),
            .depositOut(depositOut[lane][SUM-1:0]), .scalarOut(scalarAfter), .rayValid(rayValid[lane]), .rayOut(ray));
        assign unshotOut[lane][63:ENERGY] = '0;
        assign depositOut[lane][63:SUM] = '0;
        assign freshOut[lane] = {{(63 - ENERGY) {freshAfter[ENERGY]}}, freshAfter};
        assign scalarOut[lane] = {{(64 - SCALAR) {signedValue & scalarAfter[SCALAR-1]}}, scalarAfter};
        assign valueOut[lane] = {{(64 - ENERGY) {backproject & ray[RAY-1]}}, ray[RAY-1:WEIGHT+1]};
        assign weightOut[lane] = {{(63 - WEIGHT) {1'b0}}, ray[WEIGHT:0]};
    end
endmodule
