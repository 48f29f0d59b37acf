"""A page as a browser takes it apart."""

from html.parser import HTMLParser

VOID = {"meta", "link", "img", "input", "br", "hr", "line"}
APART = {"td", "th", "tr", "li", "p", "h2", "h3", "caption"}  # what text a browser sets apart


class Page(HTMLParser):
    """Elements in order, with the attributes and the text of each; tags must nest."""

    def __init__(self, html):
        super().__init__(convert_charrefs=True)
        self.elements = []
        self.open = []
        self.feed(html)
        self.close()
        assert not self.open, f"not closed: {self.open_tags()}"

    def open_tags(self):
        return [element["tag"] for element in self.open]

    def handle_starttag(self, tag, attrs):
        if tag in APART:
            self.handle_data(" ")
        element = {"tag": tag, "attrs": dict(attrs), "text": "", "within": self.open_tags()}
        self.elements.append(element)
        if tag not in VOID:
            self.open.append(element)

    def handle_startendtag(self, tag, attrs):
        self.handle_starttag(tag, attrs)
        if tag not in VOID:
            self.open.pop()

    def handle_endtag(self, tag):
        open_tags = self.open_tags()
        assert open_tags[-1:] == [tag], f"</{tag}> where {open_tags} are open"
        self.open.pop()

    def handle_data(self, data):
        for element in self.open:
            element["text"] += data

    def all(self, tag):
        return [element for element in self.elements if element["tag"] == tag]

    def by_id(self, name):
        (element,) = [element for element in self.elements if element["attrs"].get("id") == name]
        return element


def words(text):
    return " ".join(text.split())
