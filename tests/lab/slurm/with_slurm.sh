#!/usr/bin/env bash
# Runs a command with a Slurm of one node, this machine, and takes it down again:
#
#     with_slurm.sh COMMAND [ARGUMENT...]
#
# Arrays are small there (4 tasks) and jobs soon forgotten (2 s), so that lists are cut into several arrays and jobs vanish
# while others run. Everything lies in a temporary folder that is removed at the end; neither systemd nor root is needed. Exits with 77
# and says why where Slurm or MUNGE is not installed, or slurmd has no cgroups. PLUMBLINE_SLURM_KEEP=1 leaves the folder with the logs.
set -euo pipefail
PATH=$PATH:/usr/sbin:/sbin

for program in munged slurmctld slurmd sbatch squeue scancel sinfo; do
  command -v "$program" >/dev/null || { echo "skipped: there is no $program (Debian: slurm-wlm, munge)"; exit 77; }
done

folder=$(mktemp -d "${TMPDIR:-/tmp}/plumbline_slurm.XXXXXX")
pids=()

# Whatever a daemon started itself ends with it: job steps are children of their slurmstepd, which slurmd leaves alone.
cleanup() {
  trap - EXIT INT TERM
  if [[ -s $folder/slurm.conf ]]; then timeout 10 scancel --user="$(id -un)" 2>/dev/null || true; fi
  local pid
  for ((i = ${#pids[@]} - 1; i >= 0; --i)); do kill "${pids[i]}" 2>/dev/null || true; done
  for pid in "${pids[@]}"; do
    for _ in {1..50}; do kill -0 "$pid" 2>/dev/null || break; sleep 0.1; done
    kill -KILL "$pid" 2>/dev/null || true
    wait "$pid" 2>/dev/null || true
  done
  if [[ -n ${PLUMBLINE_SLURM_KEEP:-} ]]; then echo "kept: $folder"; else rm -rf "$folder"; fi
}
trap cleanup EXIT
trap 'exit 143' INT TERM

free_port() { python3 -c 'import socket; s = socket.socket(); s.bind(("127.0.0.1", 0)); print(s.getsockname()[1])'; }

# Waits until a command succeeds; $1 is what it waits for.
await() {
  local what=$1 i
  shift
  for ((i = 0; i < 300; ++i)); do "$@" >/dev/null 2>&1 && return; sleep 0.1; done
  if [[ $what == slurmd ]] && grep -qi cgroup "$folder/slurmd.log" "$folder/slurmd.out" 2>/dev/null; then
    echo "skipped: slurmd finds no cgroups here, as in a plain chroot: $(grep -him1 cgroup "$folder/slurmd.log" "$folder/slurmd.out" | head -n 1)"
    exit 77
  fi
  echo "with_slurm: $what did not come up; its log:" >&2
  tail -n 20 "$folder/$what.log" >&2
  exit 1
}

mkdir "$folder"/{munge,state,spool}
chmod 755 "$folder"
chmod 700 "$folder/munge"
(umask 077; head -c 1024 /dev/urandom >"$folder/munge.key")
socket=$folder/munge.socket
# --force: the temporary folder stands in one that everybody may write to.
munged --foreground --force --num-threads=2 --key-file="$folder/munge.key" --socket="$socket" --pid-file="$folder/munge/pid" \
  --seed-file="$folder/munge/seed" --log-file="$folder/munged.log" >"$folder/munged.out" 2>&1 &
pids+=($!)
await munged munge --socket="$socket" --no-input

host=$(hostname -s)
cat >"$folder/slurm.conf" <<CONF
ClusterName=plumbline
SlurmctldHost=$host(127.0.0.1)
SlurmctldPort=$(free_port)
SlurmdPort=$(free_port)
SlurmUser=$(id -un)
SlurmdUser=$(id -un)
AuthType=auth/munge
AuthInfo=socket=$socket
CryptoType=crypto/munge
CredType=cred/munge
StateSaveLocation=$folder/state
SlurmdSpoolDir=$folder/spool
SlurmctldPidFile=$folder/slurmctld.pid
SlurmdPidFile=$folder/slurmd.pid
SlurmctldLogFile=$folder/slurmctld.log
SlurmdLogFile=$folder/slurmd.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
MpiDefault=none
ReturnToService=2
SchedulerParameters=sched_interval=1,batch_sched_delay=0
SchedulerType=sched/builtin
MinJobAge=2
MaxArraySize=4
KillWait=2
NodeName=$host NodeAddr=127.0.0.1 CPUs=$(nproc) State=UNKNOWN
PartitionName=test Nodes=$host Default=YES MaxTime=INFINITE State=UP
CONF
export SLURM_CONF=$folder/slurm.conf
slurmctld -D -f "$SLURM_CONF" >"$folder/slurmctld.out" 2>&1 &
pids+=($!)
await slurmctld sinfo
slurmd -D -f "$SLURM_CONF" >"$folder/slurmd.out" 2>&1 &
pids+=($!)
await slurmd bash -c '[[ $(sinfo --noheader --format=%T) == idle ]]'

status=0
"$@" || status=$?
exit $status
