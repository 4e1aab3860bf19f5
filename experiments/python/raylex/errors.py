"""What raylex raises."""


class RaylexError(Exception):
    """Input that cannot be used. ``str()`` is the whole message, as the program prints it.

    :ivar message: one sentence: what was found and what was expected
    :ivar file: path, or what the text is ("channel 'direct'", "render()"); '' when there is none
    :ivar line: from 1; 0: not known
    :ivar column: in bytes, from 1; 0: not known
    :ivar excerpt: the line of text
    :ivar hint: near misses, the next thing to try
    """

    def __init__(self, text, *, message=None, file="", line=0, column=0, excerpt="", hint=""):
        super().__init__(text)
        self.message = text if message is None else message
        self.file = file
        self.line = line
        self.column = column
        self.excerpt = excerpt
        self.hint = hint
