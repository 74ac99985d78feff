# Reads a call graph that gcc wrote with -fcallgraph-info=su. Prints for each function that users
# call the most that it takes of the stack, with all that it calls; nothing calls itself. What the
# C library's functions take is not in the graph: they are named.
function most(node,    i, one, deepest)
{
    if (!(node in known)) {
        for (i = 1; i <= calls[node]; i++) {
            one = most(called[node, i])
            deepest = one > deepest ? one : deepest
        }
        known[node] = (node in own ? own[node] : 0) + deepest
    }
    return known[node]
}

function reach(node, from,    i)
{
    if (seen[from, node]++) {
        return
    }
    if (!(node in own)) {
        beside[from] = beside[from] (beside[from] == "" ? ", and what these take: " : ", ") node
    }
    for (i = 1; i <= calls[node]; i++) {
        reach(called[node, i], from)
    }
}

{
    split($0, part, "\"")
}

/^node:/ && match($0, /[0-9]+ bytes \(/) {
    own[part[2]] = substr($0, RSTART, RLENGTH - 8) + 0
    order[++nodes] = part[2]
}

/^edge:/ {
    called[part[2], ++calls[part[2]]] = part[4]
}

END {
    for (k = 1; k <= nodes; k++) {
        # Those that only the file itself can call bear its name.
        if (order[k] !~ /:/) {
            reach(order[k], order[k])
            printf "stack [bytes] at most: %d %s%s\n", most(order[k]), order[k], beside[order[k]]
        }
    }
}
