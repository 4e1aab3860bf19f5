# A Slurm of its own on this machine, in a folder of its own: munged, slurmctld and slurmd, as root and without systemd.
# Sourced by slurm.sh. begin_slurm FOLDER CORES starts it and sets $SLURM_CONF; end_slurm ends what it started.

slurm_pids=()

# What is missing here, or nothing.
slurm_lacks() {
    local tool
    [ "$(id -u)" = 0 ] || { echo "must be root"; return; }
    for tool in munged slurmctld slurmd sbatch squeue scancel scontrol; do
        PATH=$PATH:/usr/sbin command -v $tool >/dev/null || { echo "needs the packages slurm-wlm and munge"; return; }
    done
}

wait_for() {  # wait_for SECONDS COMMAND...: until it succeeds
    local end=$(($(date +%s) + $1))
    shift
    until "$@" >/dev/null 2>&1; do
        [ "$(date +%s)" -lt "$end" ] || return 1
        sleep 0.2
    done
}

begin_slurm() {
    local folder=$1 cores=$2 host
    host=$(hostname -s)
    PATH=$PATH:/usr/sbin
    mkdir -p "$folder"/{state,spool,munge} && chmod 755 "$folder" && chmod 700 "$folder/munge"
    dd if=/dev/urandom of="$folder/munge/key" bs=1 count=1024 2>/dev/null
    chmod 600 "$folder/munge/key"
    cat >"$folder/slurm.conf" <<END
ClusterName=raylex
SlurmctldHost=$host
SlurmUser=root
SlurmdUser=root
AuthType=auth/munge
# A task that is requeued begins again once its old credential is no good: after this many seconds.
AuthInfo=socket=$folder/munge/socket,cred_expire=5
SlurmctldPort=$((20000 + RANDOM % 5000))
SlurmdPort=$((25000 + RANDOM % 5000))
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
SchedulerParameters=batch_sched_delay=0,sched_min_interval=100000
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
MpiDefault=none
ReturnToService=2
JobRequeue=1
KillWait=2
NodeName=$host NodeAddr=127.0.0.1 CPUs=$cores RealMemory=$(free -m | awk '/^Mem/ {print $2 - 500}') State=UNKNOWN
PartitionName=main Nodes=$host Default=YES MaxTime=INFINITE State=UP
END
    export SLURM_CONF=$folder/slurm.conf
    munged --foreground --force --socket="$folder/munge/socket" --key-file="$folder/munge/key" \
        --log-file="$folder/munge/log" --pid-file="$folder/munge/pid" --seed-file="$folder/munge/seed" \
        >"$folder/munged.out" 2>&1 &
    slurm_pids+=($!)
    wait_for 20 test -S "$folder/munge/socket" || return 1
    slurmctld -D -f "$SLURM_CONF" >"$folder/slurmctld.out" 2>&1 &
    slurm_pids+=($!)
    slurmd -D -f "$SLURM_CONF" -N "$host" >"$folder/slurmd.out" 2>&1 &
    slurm_pids+=($!)
    wait_for 60 bash -c 'sinfo -h -o %T | grep -q idle'
}

end_slurm() {
    local pid
    [ ${#slurm_pids[@]} = 0 ] && return
    scancel --quiet --state=PENDING --user=root 2>/dev/null
    scancel --quiet --user=root 2>/dev/null
    wait_for 20 bash -c '[ -z "$(squeue -h)" ]'
    for pid in "${slurm_pids[@]}"; do kill "$pid" 2>/dev/null; done
    for pid in "${slurm_pids[@]}"; do wait "$pid" 2>/dev/null; done
    slurm_pids=()
}
