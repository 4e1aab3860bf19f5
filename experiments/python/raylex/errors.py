"""The exception of raylex."""


class RaylexError(Exception):
    """Invalid input. ``str()`` returns the whole message, as printed by the program.

    :ivar message: one sentence with what was found and what was expected
    :ivar file: path of the file, or name of the text ("channel 'direct'", "render()"); '' if there is none
    :ivar line: from 1; 0: unknown
    :ivar column: in bytes, from 1; 0: unknown
    :ivar excerpt: the line of source text
    :ivar hint: the closest match, or another suggestion
    """

    def __init__(self, text, *, message=None, file="", line=0, column=0, excerpt="", hint=""):
        super().__init__(text)
        self.message = text if message is None else message
        self.file = file
        self.line = line
        self.column = column
        self.excerpt = excerpt
        self.hint = hint
