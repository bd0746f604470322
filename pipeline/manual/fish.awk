# SPDX-License-Identifier: Apache-2.0
# Completion for fish; behind values.awk.

# Options of "complete" for a value, or a file behind the options, of that kind.
function arguments(kind_of_file) {
    if (kind_of_file == "folder")
        return "-x -a '(__fish_complete_directories)'"
    if (kind_of_file == "any")
        return "-r -F"
    return kind_of_file == "none" ? "-x" : "-x -a '(__fewray_files " kind_of_file ")'"
}

function value() {
    if (kind == "flag")
        return ""
    if (choices != "")
        return " -x -a " quote(choices, "")
    return " " arguments(files_of_option)
}

END {
    print "# fish completion for fewray, made by its build of the commands' own tables of options.\n"
    print "# Folders, and files with one of the endings."
    print "function __fewray_files\n    set -l endings (string join '|' $argv)"
    print "    __fish_complete_path (commandline -ct) | string match -r \".*(?:/|\\.(?:$endings))(?:\\t.*)?\\$\"\nend\n"
    print "complete -c fewray -f"
    print "complete -c fewray -n __fish_use_subcommand -l help -d 'list the commands'"
    print "complete -c fewray -n __fish_use_subcommand -l version -d 'print the version'"
    for (c = 1; c <= command_count; c++) {
        name = commands[c]
        seen = "complete -c fewray -n '__fish_seen_subcommand_from " name "'"
        print "\ncomplete -c fewray -n __fish_use_subcommand -a " name " -d " quote(about[name], "\\'")
        if (files[name] != "none")
            print seen " " arguments(files[name])
        for (i = 1; i <= option_count[name]; i++) {
            read_option(name, i)
            print seen (letter == "" ? "" : " -s " letter) " -l " option value() " -d " quote(help, "\\'")
        }
    }
}
