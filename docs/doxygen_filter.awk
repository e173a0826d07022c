# What Doxygen reads of a header: our comments are plain, and stand above what they describe or
# behind it on its line, to be continued in the same column.
function text(comment) {
    gsub(/[@\\#]/, "\\\\&", comment)
    gsub(/</, "\\&lt;", comment)
    gsub(/>/, "\\&gt;", comment)
    return comment
}
NR == 1 { print "/// @file"; opening = 1 }
/^ *\/\/ / {
    at = index($0, "//")
    mark = at == column ? "///< " : "/// "
    print substr($0, 1, at - 1) mark text(substr($0, at + 3))
    next
}
{ column = 0 }
opening { print ""; opening = 0 }
/\)  \/\/ / { print; next }  # of a function's head: Doxygen would take it for a parameter's
/[^ ].*  \/\/ / {
    column = index($0, "  // ") + 2
    print substr($0, 1, column - 1) "///< " text(substr($0, column + 3))
    next
}
{ print }
