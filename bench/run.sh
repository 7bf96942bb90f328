#!/usr/bin/env bash
# Builds what is measured, measures it, prints the table of what was asked and what was reached, and stores it in
# bench/results/. Usage: bench/run.sh [--quick] [--only sweep,convergence,cycles,large,light,ct,photo,cube4].
# docs/benchmarks.md says what the rows mean.
set -euo pipefail
cd "$(dirname "$0")/.."
case " $* " in *" -h "* | *" --help "*) exec python3 bench/harness/run.py --help ;; esac

targets=(raysweep_app raysweep_bench raysweep_convergence raysweep_large raysweep_lit_error)
scripts/build.sh --target "${targets[@]}" >/dev/null
exec python3 bench/harness/run.py "$@"
