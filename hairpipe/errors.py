"""The one exception for input that a person can mend: said in one message, never shown as a traceback."""


class BadInput(Exception):
    """Something given to us is wrong; the message says what, where and what would be right.

    what   the fault, as a sentence without a full stop
    where  file, line, node or field it was found in
    right  what would be accepted instead
    """

    def __init__(self, what: str, *, where: object = None, right: str | None = None) -> None:
        self.what, self.where, self.right = what, where, right
        place = f"{where}: " if where is not None else ""
        mend = f" ({right})" if right else ""
        super().__init__(f"{place}{what}{mend}")
