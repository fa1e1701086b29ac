#!/bin/sh
# A campaign as an array of jobs on a Slurm of one node, whose daemons are started here with ports,
# key and folders of their own: the merged table is that of one run on this machine, byte by byte, also
# after a job that was killed half-way and requeued.
set -eu
cd "$(dirname "$0")/../.."
PATH=$PATH:/usr/sbin
tests/interop/needs.sh munged slurmctld slurmd sbatch scontrol
tools/build.sh --quiet
target=$(realpath "${CARGO_TARGET_DIR:-target}")
lmpc=$target/release/lmpc
work=$(mktemp -d)
daemons=
finish() {
    code=$?
    [ $code = 0 ] || tail -n 20 "$work"/*.log >&2
    # shellcheck disable=SC2086 # one word per process
    [ -z "$daemons" ] || kill $daemons 2>/dev/null || true
    wait
    rm -rf "$work"
    exit $code
}
trap finish EXIT
chmod 755 "$work"
mkdir "$work/state" "$work/spool" "$work/munge"
head -c 64 /dev/urandom > "$work/munge/key"
chmod 400 "$work/munge/key"
munged --foreground --force --key-file "$work/munge/key" --socket "$work/munge/socket" \
    --pid-file "$work/munge/pid" --seed-file "$work/munge/seed" --log-file "$work/munge.log" > "$work/munged.log" 2>&1 &
daemons="$!"
host=$(hostname -s)
port=$((20000 + $$ % 20000))
cat > "$work/slurm.conf" <<CONF
ClusterName=lmpc
SlurmctldHost=$host(127.0.0.1)
SlurmUser=$(id -un)
SlurmdUser=$(id -un)
SlurmctldPort=$port
SlurmdPort=$((port + 1))
AuthType=auth/munge
# A requeued job waits until its credential has expired.
AuthInfo=socket=$work/munge/socket,cred_expire=5
CredType=cred/munge
StateSaveLocation=$work/state
SlurmdSpoolDir=$work/spool
SlurmctldPidFile=$work/slurmctld.pid
SlurmdPidFile=$work/slurmd.pid
MpiDefault=none
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SchedulerParameters=batch_sched_delay=0,sched_interval=1
MinJobAge=300
ReturnToService=2
NodeName=$host NodeAddr=127.0.0.1 CPUs=$(nproc) State=UNKNOWN
PartitionName=all Nodes=$host Default=YES MaxTime=INFINITE State=UP
CONF
export SLURM_CONF="$work/slurm.conf"
waited() { # what, shell command
    for _ in $(seq 100); do
        if sh -c "$2" > /dev/null 2>&1; then return; fi
        sleep 0.1
    done
    echo "slurm: $1 did not come up" >&2
    exit 1
}
waited munged "test -S $work/munge/socket"
slurmctld -D -f "$SLURM_CONF" > "$work/slurmctld.log" 2>&1 &
daemons="$daemons $!"
slurmd -D -N "$host" -f "$SLURM_CONF" > "$work/slurmd.log" 2>&1 &
daemons="$daemons $!"
waited "the node" "sinfo --noheader --format %t | grep -q idle"

cat > "$work/slurmed.toml" <<'CAMPAIGN'
laps = 3
seeds = 6
[set.config]
warm_up.laps = 1
CAMPAIGN
"$lmpc" --quiet study "$work/slurmed.toml" --jobs 2 --out "$work/here" > /dev/null
"$lmpc" study "$work/slurmed.toml" --slurm --shards 2 --jobs 1 --out "$work/there" > "$work/job.sh"
job=$(cd "$work" && sbatch --parsable job.sh)
# The first job is stopped and queued again as soon as it has a line.
waited "the first line" "grep -c . $work/there/shard-1-of-2/runs.csv | grep -qv '^[01]$'"
scontrol requeue "${job}_1"
for _ in $(seq 600); do
    [ -n "$(squeue --noheader --job "$job" 2>/dev/null)" ] || break
    sleep 0.2
done
[ -z "$(squeue --noheader --job "$job")" ] || { squeue >&2; exit 1; }
"$lmpc" study merge "$work"/there/shard-* --out "$work/there" > /dev/null
cmp "$work/here/runs.csv" "$work/there/runs.csv"
restarts=$(scontrol show job "${job}_1" | grep -o 'Restarts=[0-9]*')
[ "$restarts" = Restarts=1 ] || { echo "slurm: $restarts, expected one" >&2; exit 1; }
echo "slurm $(slurmctld -V): $(($(grep -c . "$work/there/runs.csv") - 1)) runs in two jobs, one of them" \
    "killed and requeued: the table of one run on this machine, byte by byte"
