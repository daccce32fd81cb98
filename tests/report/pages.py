"""What is on a page: its tags, links and text."""

from html.parser import HTMLParser


class Page(HTMLParser):
    """Tags, links and text of a page, and whether its tags are balanced."""

    _VOID = ("meta", "img", "link", "br", "hr", "input")

    def __init__(self, text):
        super().__init__()
        self.tags, self.addresses, self.text, self._open = [], [], [], []
        self.feed(text)
        assert self._open == []

    @property
    def words(self):
        """The text of the page as one line."""
        return " ".join(" ".join(self.text).split())

    def handle_starttag(self, tag, attrs):
        self.tags.append(tag)
        self.addresses += [value for name, value in attrs if name in ("src", "href", "srcset", "action")]
        if tag not in self._VOID:
            self._open.append(tag)

    def handle_endtag(self, tag):
        assert self._open.pop() == tag

    def handle_data(self, data):
        self.text.append(data)
