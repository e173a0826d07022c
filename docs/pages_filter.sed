# The pages as Doxygen takes them: pictures by their names, links to whole pages (it knows no
# sections of others), and no links to files that are no pages.
s|!\[([^]]*)\]\([^)]*/|![\1](|g
s,\]\(([A-Za-z./-]+\.md)#[^)]*\),](\1),g
s|\[([^]]*)\]\(((\.\./)*examples/[^)]*\|LICENSE\|CITATION\.cff)\)|\1|g
