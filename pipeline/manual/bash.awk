# SPDX-License-Identifier: Apache-2.0
# Completion for bash; behind values.awk. It needs nothing but bash 4.

# What stands behind an option, "COMMAND --OPTION", as a call.
function value_call(    n, parts) {
    if (kind == "choice")
        return "_fewray_words \"" choices "\""
    if (kind == "names" && choices != "")
        return "_fewray_list \"" choices "\""
    return files_call(files_of_option)
}

function files_call(kind_of_file) {
    if (kind_of_file == "none")
        return ":"
    if (kind_of_file == "any")
        return "_fewray_files ''"
    if (kind_of_file == "folder")
        return "_fewray_files"
    return "_fewray_files " kind_of_file
}

END {
    print "# bash completion for fewray, made by its build of the commands' own tables of options.\n"
    print "_fewray_words() {\n    mapfile -t COMPREPLY < <(compgen -W \"$1\" -- \"$cur\")\n}\n"
    print "# NAME[,NAME...]"
    print "_fewray_list() {\n    local before="
    print "    [[ $cur == *,* ]] && before=${cur%,*},"
    print "    mapfile -t COMPREPLY < <(compgen -P \"$before\" -W \"$1\" -- \"${cur##*,}\")\n}\n"
    print "# Folders, and files with one of the endings; '' stands for any."
    print "_fewray_files() {\n    local ending"
    print "    compopt -o filenames 2>/dev/null # outside completion it fails"
    print "    mapfile -t COMPREPLY < <(\n        {\n            compgen -d -- \"$cur\""
    print "            for ending; do\n                compgen -f -X \"!*${ending:+.$ending}\" -- \"$cur\"\n            done"
    print "        } | sort -u\n    )\n}\n"
    print "_fewray() {"
    print "    local cur=${COMP_WORDS[COMP_CWORD]} before=$((COMP_CWORD - 1))"
    print "    COMPREPLY=()"
    print "    # --option=value comes as three words"
    print "    if [[ $cur == = ]]; then\n        cur="
    print "    elif [[ ${COMP_WORDS[before]} == = ]]; then\n        before=$((before - 1))\n    fi"
    print "    if ((COMP_CWORD == 1)); then"
    printf "        _fewray_words \""
    for (c = 1; c <= command_count; c++)
        printf "%s ", commands[c]
    print "--help --version\"\n        return\n    fi"
    print "    case \"${COMP_WORDS[1]} ${COMP_WORDS[before]}\" in"
    for (c = 1; c <= command_count; c++)
        for (i = 1; i <= option_count[commands[c]]; i++) {
            read_option(commands[c], i)
            if (kind == "flag")
                continue
            pattern = "\"" commands[c] " --" option "\""
            if (letter != "")
                pattern = pattern " | \"" commands[c] " -" letter "\""
            printf "    %s) %s; return ;;\n", pattern, value_call()
        }
    print "    esac"
    print "    case \"${COMP_WORDS[1]} $cur\" in"
    for (c = 1; c <= command_count; c++) {
        printf "    \"%s -\"*) _fewray_words \"", commands[c]
        for (i = 1; i <= option_count[commands[c]]; i++) {
            read_option(commands[c], i)
            printf "%s%s", letter == "" ? "" : "-" letter " ", "--" option (i < option_count[commands[c]] ? " " : "")
        }
        print "\" ;;"
        printf "    \"%s \"*) %s ;;\n", commands[c], files_call(files[commands[c]])
    }
    print "    esac\n}\ncomplete -F _fewray fewray"
}
