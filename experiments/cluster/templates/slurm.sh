#!/bin/bash
# {{job}}, made by raylex {{version}} from the template slurm.sh: what your site asks for may be written there
# (share/raylex/cluster/slurm.sh), or given to 'raylex submit' by --option.
#SBATCH --job-name="{{job}}"
#SBATCH --output="{{log}}"
#SBATCH --open-mode=append
#SBATCH --requeue
#SBATCH --nodes=1
#SBATCH --ntasks=1
#SBATCH --cpus-per-task={{cores}}
{{#memory}}
#SBATCH --mem={{memory}}M
{{/memory}}
{{#array}}
#SBATCH --array={{array}}
{{/array}}
{{#exclusive}}
#SBATCH --exclusive
{{/exclusive}}
# A minute before its time is up a task is told, and saves what it has.
#SBATCH --signal=B:TERM@60
{{#options}}
{{options}}
{{/options}}
{{command}}
