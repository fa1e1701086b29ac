#!/bin/sh
# 2,000 short runs in one process and in three shards, of which one is killed half-way and resumed: the merged
# table has the same bytes. Then each built-in study against its file in examples/studies: the same rows.
#
#   tests/interop/campaign.sh [--full]     --full: ten seeds and twenty laps, as the files have them
# LMPC names a program that is built already.
set -eu
cd "$(dirname "$0")/../.."
lmpc=${LMPC:-${CARGO_TARGET_DIR:-target}/release/lmpc}
[ -n "${LMPC:-}" ] || tools/build.sh --quiet
out=${CARGO_TARGET_DIR:-target}/campaign
rm -rf "$out" && mkdir -p "$out"
study() { "$lmpc" --quiet study "$@" >/dev/null; }
begun() { date +%s; }

cat >"$out/short.toml" <<'CAMPAIGN'
title = "2,000 short runs"
laps = 1
seeds = 2
[set]
config.warm_up.laps = 1
[[axis]]
key = "config.horizon.steps"
values = [9, 10, 11, 12]
[[axis]]
join = [
  { key = "plant.mu", random = { from = 0.6, to = 1.1, count = 250, seed = 1 } },
  { key = "plant.noise", random = { from = 0.0001, to = 0.002, count = 250, seed = 2, log = true } },
]
[[record]]
column = "v_x_mps"
take = ["max", 0.9]
[limits]
failed_runs = 2000
CAMPAIGN
start=$(begun)
study "$out/short.toml" --out "$out/whole"
whole=$(($(begun) - start))
rows() { grep -c . "$1" 2>/dev/null || echo 0; }
[ "$(rows "$out/whole/runs.csv")" = 2001 ] || { echo "campaign: $(rows "$out/whole/runs.csv") lines" >&2; exit 1; }

start=$(begun)
study "$out/short.toml" --shard 1/3 --out "$out/parts"
second=$out/parts/shard-2-of-3/runs.csv
"$lmpc" --quiet study "$out/short.toml" --shard 2/3 --out "$out/parts" >/dev/null &
shard=$!
trap 'kill -KILL $shard 2>/dev/null || true' EXIT
until [ "$(rows "$second")" -gt 300 ]; do
    kill -0 $shard || { echo "campaign: the shard ended before it was killed" >&2; exit 1; }
    sleep 0.02
done
kill -KILL $shard
wait $shard 2>/dev/null || true
trap - EXIT
kept=$(($(rows "$second") - 1))
[ "$kept" -lt 667 ] || { echo "campaign: the shard was killed too late" >&2; exit 1; }
study "$out/short.toml" --shard 3/3 --out "$out/parts"
if study merge "$out"/parts/shard-* --out "$out/early"; then
    echo "campaign: a shard that lacks runs was merged as a whole" >&2
    exit 1
fi
study "$out/short.toml" --shard 2/3 --out "$out/parts"
study merge "$out"/parts/shard-* --out "$out/merged"
cmp "$out/whole/runs.csv" "$out/merged/runs.csv"
echo "campaign: 2,000 runs in $whole s, in three shards $(($(begun) - start)) s, one killed after $kept rows and" \
    "resumed: the same bytes"

seeds=2 laps=2
if [ "${1:-}" = --full ]; then seeds=10 laps=20; fi
for name in crc bandwidth hardware; do
    study $name --seeds $seeds --out "$out/$name-built-in"
    sed "s/^seeds = .*/seeds = $seeds/" examples/studies/$name.toml >"$out/$name.toml"
    study "$out/$name.toml" --out "$out/$name"
    python3 tests/interop/campaign_rows.py $name "$out/$name-built-in" "$out/$name"
done
study tracks --car barc f1tenth mini kart formula_student --random 20 --random-seed 5000 --seeds 1 --laps $laps \
    --out "$out/tracks-built-in" || [ $? = 3 ] # a car may leave its track
sed "s/^laps = .*/laps = $laps/" examples/studies/tracks.toml >"$out/tracks.toml"
study "$out/tracks.toml" --out "$out/tracks"
python3 tests/interop/campaign_rows.py tracks "$out/tracks-built-in" "$out/tracks"
