# {{name}}, made by raylex {{version}}
{{#notes}}
# {{.}}
{{/notes}}
# make -f THIS_FILE -j N; begun again it does what is not done. A rule is called like the file it makes, or, where that
# has characters that Make cannot write, like its command.
.PHONY: all{{#commands}}{{^plain}} {{{rule}}}{{/plain}}{{/commands}}
all:{{#commands}}{{#last}} {{{goal}}}{{/last}}{{/commands}}
{{#commands}}

# {{{command_name}}}: {{{resources}}}
{{{goal}}}:{{#needs}} {{{goal}}}{{/needs}}
	{{command}}
{{/commands}}
