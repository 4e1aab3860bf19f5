# {{name}}, made by raylex {{version}}
{{#notes}}
# {{.}}
{{/notes}}
# Run: make -f THIS_FILE -j N. A second run makes only missing files. A rule has the name of the file that it makes. If
# Make cannot write this name, the rule has the name of its command.
.PHONY: all{{#commands}}{{^plain}} {{{rule}}}{{/plain}}{{/commands}}
all:{{#commands}}{{#last}} {{{goal}}}{{/last}}{{/commands}}
{{#commands}}

# {{{command_name}}}: {{{resources}}}
{{{goal}}}:{{#needs}} {{{goal}}}{{/needs}}
	{{command}}
{{/commands}}
