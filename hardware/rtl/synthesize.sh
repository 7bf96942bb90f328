#!/usr/bin/env bash
# Synthesizes one pipeline with Yosys into generic cells of one bit, and prints how many there are, and how many of them
# follow each other at most between registers. Memories (beam buffers, table of factors) are left out and counted in bits.
set -euo pipefail
cd "$(dirname "$0")"
command -v yosys >/dev/null || { echo "skipped: Yosys is missing (scripts/setup.sh --tests)" && exit 77; }
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# row NAME TOP COMMAND PARAMETER VALUE...: COMMAND changes the netlist before it is optimised.
row() {
    local name=$1 top=$2 command=$3 parameters=""
    shift 3
    while [ $# -gt 0 ]; do
        ! grep -qw "parameter int $1" "$top.sv" || parameters+=" -set $1 $2"
        shift 2
    done
    local read="read_verilog -sv *.sv
        chparam $parameters $top
        hierarchy -check -top $top"
    yosys -q >"$work/log" 2>&1 <<END || { cat "$work/log" >&2 && return 1; }
$read
cd $top
$command
cd ..
hierarchy -check -top $top
proc
flatten
tee -o $work/memories stat
design -reset
$read
blackbox *beam_memory* *factor_table*
proc
flatten
check -assert
cd $top
$command
cd ..
synth -top $top
tee -o $work/cells stat
tee -o $work/path ltp -noff
END
    awk -v name="$name" '
        FILENAME ~ /memories$/ && /Number of memory bits/ { bits = $NF }
        FILENAME ~ /cells$/ && /\$_.*DFF/ { registers += $2; next }
        FILENAME ~ /cells$/ && /\$_/ { cells += $2 }
        FILENAME ~ /path$/ && /length=/ { gsub(/[^0-9]/, "", $NF); path = $NF }
        END { printf "| %s | %d | %d | %d | %d |\n", name, cells, registers, path, bits }' "$work"/{memories,cells,path}
}

echo "| | gates | flip-flops | longest path, gates | memory, bits |"
echo "| --- | --- | --- | --- | --- |"
wide=(ENERGY 24 PART 16 WEIGHT 12 SCALAR 24 SUM 48 FACTOR 32)
usual=(ENERGY 16 PART 12 WEIGHT 12 SCALAR 16 SUM 40 FACTOR 32)
narrow=(ENERGY 8 PART 8 WEIGHT 8 SCALAR 8 SUM 24 FACTOR 28)
row "24/16/12" reverse_lane "" "${wide[@]}"
row "16/12/12" reverse_lane "" "${usual[@]}"
row "8/8/8" reverse_lane "" "${narrow[@]}"
row "16/12/12, truncates" reverse_lane "" "${usual[@]}" ROUNDING 0
row "16/12/12, stochastic" reverse_lane "" "${usual[@]}" ROUNDING 2
# The pass is fixed, and what the other one needs is optimised away.
row "16/12/12, illuminates only" reverse_lane "
    delete t:*factor_table*
    delete -input backproject
    connect -nounset -set backproject 1'b0" "${usual[@]}"
row "16/12/12, backprojects only" reverse_lane "
    delete -input backproject offerFromLeft offersFromLeft
    connect -nounset -set backproject 1'b1
    connect -nounset -set offerFromLeft 30'b0
    connect -nounset -set offersFromLeft 30'b0" "${usual[@]}"
for stage in ray_across ray_along exchange offer_across offer_along ray_update; do
    row "$stage, 16/12/12" "$stage" "" "${usual[@]}"
done
