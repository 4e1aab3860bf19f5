#!/bin/bash
# {{job}}, made by raylex {{version}} from the template slurm.sh. Add options of your site to the template
# (share/raylex/cluster/slurm.sh), or pass them to 'raylex submit' by --option.
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
# Slurm signals a task one minute before its time limit, so that it can save its work.
#SBATCH --signal=B:TERM@60
{{#options}}
{{options}}
{{/options}}
{{command}}
