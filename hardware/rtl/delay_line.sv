// Registers that hold what has to wait for the stages beside it.
module delay_line #(
    parameter int BITS = 1,
    parameter int CYCLES = 2  // at least 2
) (
    input logic clk,
    input logic [BITS-1:0] in,
    output logic [BITS-1:0] out
);
    logic [CYCLES*BITS-1:0] held;
    always_ff @(posedge clk) held <= {held[(CYCLES-1)*BITS-1:0], in};
    assign out = held[CYCLES*BITS-1:(CYCLES-1)*BITS];
endmodule
