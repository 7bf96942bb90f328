// Rounds to fewer bits, as FixedPoint::shifted does: `value` / 2^SHIFT.
//
// Combinational, of words with or without a sign. ROUNDING: 0 truncates, 1 to the nearest with halves up, 2 stochastic, with a random word of SHIFT bits.
// `value` has room for what is added: the caller gives it a bit more than it needs.
module rounded #(
    parameter int WIDTH = 32,
    parameter int SHIFT = 12,
    parameter int ROUNDING = 1
) (
    input logic [WIDTH-1:0] value,
    /* verilator lint_off UNUSED */
    input logic [SHIFT-1:0] random,
    /* verilator lint_on UNUSED */
    output logic [WIDTH-SHIFT-1:0] result
);
    logic [SHIFT-1:0] added;
    generate
        if (ROUNDING == 0) assign added = '0;
        else if (ROUNDING == 1) assign added = {1'b1, {(SHIFT - 1) {1'b0}}};
        else assign added = random;
    endgenerate

    /* verilator lint_off UNUSED */
    logic [WIDTH-1:0] sum;
    /* verilator lint_on UNUSED */
    assign sum = value + {{(WIDTH - SHIFT) {1'b0}}, added};
    assign result = sum[WIDTH-1:SHIFT];
endmodule
