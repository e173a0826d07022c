# What the checks of text share. Sourced; `failed` counts the rules that are broken.
failed=0
# Reads places that break a rule, one a line; says the rule once and counts.
none() {
    local places
    places=$(cat)
    [ -z "$places" ] && return
    printf '%s:\n%s\n' "$1" "$(sed 's/^/    /' <<<"$places")"
    failed=$((failed + 1))
}
