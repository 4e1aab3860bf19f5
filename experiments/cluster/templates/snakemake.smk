# {{{name}}}, made by raylex {{{version}}}
{{#notes}}
# {{{.}}}
{{/notes}}
# Run: snakemake -s THIS_FILE --cores N. A second run makes only missing files. If Snakemake itself was killed, run it
# with --unlock first, then with --rerun-incomplete.
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
