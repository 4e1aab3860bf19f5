# {{{name}}}, made by raylex {{{version}}}
{{#notes}}
# {{{.}}}
{{/notes}}
# snakemake -s THIS_FILE --cores N; begun again it does what is not done (after a kill of Snakemake itself with --unlock
# and --rerun-incomplete).
rule all:
    input:
{{#commands}}{{#last}}
        "{{target}}",
{{/last}}{{/commands}}
{{#commands}}

rule {{{rule}}}:
    # {{{resources}}}
    input:
{{#needs}}
        "{{target}}",
{{/needs}}
    output:
        "{{target}}"
    threads: {{{cores}}}
{{#memory_known}}
    resources:
        mem_mb={{{memory_mb}}}
{{/memory_known}}
    shell:
        "{{command}}"
{{/commands}}
