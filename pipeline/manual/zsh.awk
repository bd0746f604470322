# SPDX-License-Identifier: Apache-2.0
# Completion for zsh, for its function _arguments; behind values.awk.

# A text in brackets, or a message between colons.
function in_brackets(s) {
    gsub(/[][\\:]/, "\\\\&", s)
    return s
}

function glob(kind_of_file) {
    if (kind_of_file == "any")
        return "_files"
    if (kind_of_file == "folder")
        return "_files -/"
    if (kind_of_file !~ / /) # in parentheses it would be qualifiers of the pattern
        return "_files -g \"*." kind_of_file "\""
    gsub(/ /, "|", kind_of_file)
    return "_files -g \"*.(" kind_of_file ")\""
}

# ":what:action" behind an option that takes a value.
function value(    what) {
    if (kind == "flag")
        return ""
    what = ":" in_brackets(metavar == "" ? option : metavar) ":"
    if (kind == "choice")
        return what "(" choices ")"
    if (kind == "names" && choices != "")
        return what "_sequence compadd - " choices
    return files_of_option == "none" ? what " " : what glob(files_of_option)
}

function specification(    takes, text, repeated) {
    takes = kind == "flag" ? "" : "="
    text = "[" in_brackets(help) "]" value()
    repeated = kind == "define" || kind == "names"
    if (letter == "")
        return quote((repeated ? "*" : "") "--" option takes text, "'\\''")
    return (repeated ? "'*'" : "'(-" letter " --" option ")'") "{-" letter (takes ? "+" : "") ",--" option takes "}" quote(text, "'\\''")
}

END {
    print "#compdef fewray"
    print "# zsh completion for fewray, made by its build of the commands' own tables of options.\n"
    print "local -a commands=("
    for (c = 1; c <= command_count; c++)
        print "    " quote(commands[c] ":" about[commands[c]], "'\\''")
    print ")"
    print "if ((CURRENT == 2)); then"
    print "    _describe command commands\n    _arguments '--help[list the commands]' '--version[print the version]'"
    print "    return\nfi"
    print "shift words\n((CURRENT--))"
    print "case $words[1] in"
    for (c = 1; c <= command_count; c++) {
        print commands[c] ")\n    _arguments -s \\"
        for (i = 1; i <= option_count[commands[c]]; i++) {
            read_option(commands[c], i)
            print "        " specification() " \\"
        }
        print "        " (files[commands[c]] == "none" ? "" : quote("*:file:" glob(files[commands[c]]), "")) "\n    ;;"
    }
    print "esac"
}
