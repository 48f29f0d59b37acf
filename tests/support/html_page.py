"""A page as a browser takes it apart."""

from html.parser import HTMLParser

VOID = {"meta", "link", "img", "input", "br", "hr", "line"}
APART = {"td", "th", "tr", "li", "p", "h2", "h3", "caption"}  # what text a browser sets apart


class Page(HTMLParser):
    """Elements in order, with attributes and the text within each; complains where tags do not nest."""

    def __init__(self, html):
        super().__init__(convert_charrefs=True)
        self.elements, self.open = [], []
        self.feed(html)
        self.close()
        assert not self.open, f"not closed: {[element['tag'] for element in self.open]}"

    def handle_starttag(self, tag, attrs):
        if tag in APART:
            self.handle_data(" ")
        element = {
            "tag": tag,
            "attrs": dict(attrs),
            "text": "",
            "within": [one["tag"] for one in self.open],
        }
        self.elements.append(element)
        if tag not in VOID:
            self.open.append(element)

    def handle_startendtag(self, tag, attrs):
        self.handle_starttag(tag, attrs)
        if tag not in VOID:
            self.open.pop()

    def handle_endtag(self, tag):
        assert self.open and self.open[-1]["tag"] == tag, (
            f"</{tag}> where {[one['tag'] for one in self.open]} are open"
        )
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
