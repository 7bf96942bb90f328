// What a voxel and the power that meets it do to each other (paper, Algorithm 1):
//
//     in = e α,   out = U s,   D += in,   U += g in - out + source;   the ray is offered α and out;
//                                                                    alone with the voxel, 0 and out - in
//
// Combinational. Of a group of directions that all see the same U, changes are added up in `fresh`, which has a sign, and
// become part of U in the last one. Together they shoot no more than there is, however it is rounded: U + fresh is never
// below 0. U and D saturate.
module illuminated #(
    parameter int ENERGY = 16,
    parameter int PART = 12,
    parameter int SUM = 40,
    parameter int ROUNDING = 1
) (
    input logic inject,
    input logic group,
    input logic settle,
    input logic [3*PART-1:0] random,
    input logic [ENERGY-1:0] ray,
    input logic [PART:0] opacity,
    input logic [PART:0] shot,
    input logic [PART:0] gain,
    input logic [ENERGY-1:0] source,
    input logic [ENERGY-1:0] unshot,
    input logic [ENERGY:0] fresh,
    input logic [SUM-1:0] deposit,
    output logic [ENERGY-1:0] in,
    output logic [ENERGY-1:0] out,
    output logic [ENERGY-1:0] unshotAfter,
    output logic [ENERGY:0] freshAfter,
    output logic [SUM-1:0] depositAfter
);
    localparam int WIDE = ENERGY + 3;                            // of sums of three powers
    localparam int TOTAL = (SUM > ENERGY ? SUM : ENERGY) + 1;  // of a deposit with what is added

    function automatic [WIDE-1:0] atMost(input [WIDE-1:0] power);
        atMost = !power[WIDE-1] && |power[WIDE-2:ENERGY] ? {3'b000, {ENERGY{1'b1}}} : power;
    endfunction

    logic [ENERGY-1:0] scattered, share;
    part_of #(.POWER(ENERGY), .PART(PART), .ROUNDING(ROUNDING)) taken (
        .power(ray), .part(opacity), .random(random[PART-1:0]), .result(in));
    part_of #(.POWER(ENERGY), .PART(PART), .ROUNDING(ROUNDING)) shoots (
        .power(unshot), .part(shot), .random(random[2*PART-1:PART]), .result(share));
    part_of #(.POWER(ENERGY), .PART(PART), .ROUNDING(ROUNDING)) scatters (
        .power(in), .part(gain), .random(random[3*PART-1:2*PART]), .result(scattered));

    // Not below 0: that is what this keeps to.
    logic [ENERGY+1:0] left;
    assign left = {2'b00, unshot} + {fresh[ENERGY], fresh};
    assign out = group && {2'b00, share} > left ? left[ENERGY-1:0] : share;

    /* verilator lint_off UNUSED */
    logic [WIDE-1:0] held, exchanged, changed, settled;
    /* verilator lint_on UNUSED */
    assign held = group ? {{2{fresh[ENERGY]}}, fresh} : {3'b000, unshot};
    assign exchanged = atMost(held - {3'b000, out} + {3'b000, scattered});
    assign changed = inject ? atMost(exchanged + {3'b000, source}) : exchanged;
    assign settled = atMost(changed + {3'b000, unshot});

    always_comb begin
        unshotAfter = unshot;
        freshAfter = fresh;
        if (!group) unshotAfter = changed[ENERGY-1:0];
        else if (settle) begin
            unshotAfter = settled[ENERGY-1:0];
            freshAfter = '0;
        end else freshAfter = changed[ENERGY:0];
    end

    logic [TOTAL-1:0] total;
    assign total = {{(TOTAL - SUM) {1'b0}}, deposit} + {{(TOTAL - ENERGY) {1'b0}}, in};
    assign depositAfter = |total[TOTAL-1:SUM] ? '1 : total[SUM-1:0];
endmodule
