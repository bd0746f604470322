# SPDX-License-Identifier: Apache-2.0
# What the completion of all shells reads from `fewray --help=table` (pipeline/options.h): awk -f values.awk -f SHELL.awk TABLE
#     commands[1..command_count], about[COMMAND], files[COMMAND]: what kind of file it takes
#     options[COMMAND, 1..option_count[COMMAND]]: rows, for read_option()
# A kind of file is "none", "any", "folder", or its names' endings with a space between two.
BEGIN { FS = "\t" }
$1 == "about" { commands[++command_count] = $2; about[$2] = $3 }
$1 == "command" { files[$2] = kind_of_synopsis($3) }
$1 == "option" { options[$2, ++option_count[$2]] = $0 }

function kind_of_name(name) {
    if (name ~ /SCENE/)
        return "xml gltf glb obj"
    if (name ~ /^[A-Z_]*FILE$/)
        return "any"
    if (name ~ /^[A-Z_]*DIR$/)
        return "folder"
    if (name ~ /^[A-Za-z_#]+(\.[#]+)?\.[a-z0-9]+$/)
        return substr(name, match(name, /[^.]*$/))
    return "none"
}

# Of the words before the first option.
function kind_of_synopsis(s,    i, n, words, kind, all) {
    sub(/ *\[?-.*| *\[options\].*/, "", s)
    gsub(/\.\.\.|[][]/, "", s)
    n = split(s, words, /[ |]+/)
    for (i = 1; i <= n; i++) {
        kind = kind_of_name(words[i])
        if (kind == "any")
            return kind
        if (kind != "none" && index(" " all " ", " " kind " ") == 0)
            all = all (all == "" ? "" : " ") kind
    }
    return all == "" ? "none" : all
}

# Sets letter, option, kind (flag, choice, names, number, text, define), metavar, choices, files_of_option, help.
function read_option(command, i,    f) {
    split(options[command, i], f, "\t")
    letter = f[3] == "-" ? "" : f[3]
    option = f[4]
    kind = f[5]
    metavar = f[6] == "-" ? "" : f[6]
    choices = f[7] == "-" ? "" : f[7]
    files_of_option = kind == "text" ? kind_of_name(metavar) : "none"
    help = f[9]
}

# A text between single quotes of a shell, those of the text written by their escape.
function quote(s, escape) {
    gsub(/'/, escape, s)
    return "'" s "'"
}
