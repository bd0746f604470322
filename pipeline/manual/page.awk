# SPDX-License-Identifier: Apache-2.0
# Writes the manual page of one command, or of fewray itself, in roff's macros "man".
#     awk -f page.awk -v command=NAME -v date=YYYY-MM-DD -v folder=DIR TABLE
# TABLE is what `fewray --help=table` prints (pipeline/options.h); command is "fewray" for the first page. The texts that
# no option tells stand in DIR/NAME.txt, where there is one, and DIR/every.txt: paragraphs, "# HEADING", code indented by four
# spaces, "= TERM" above a paragraph that explains it, `code` in a line, and "@FILE" for the paragraphs of another file.
BEGIN { FS = "\t" }
$1 == "version" { version = $2 }
$1 == "about" { names[++name_count] = $2; about[$2] = $3 }
$1 == "command" { synopsis[$2] = $3; text[$2] = $4 }
$1 == "option" && $2 == command { options[++option_count] = $0 }

# roff takes a hyphen for a dash, and a dot or quote that begins a line for a macro.
function plain(s) {
    gsub(/\\/, "\\e", s)
    gsub(/-/, "\\-", s)
    return s
}

function line(s,    i, n, parts) {
    n = split(plain(s), parts, "`")
    s = parts[1]
    for (i = 2; i <= n; i++)
        s = s (i % 2 ? "\\fR" : "\\fB") parts[i]
    return s ~ /^[.']/ ? "\\&" s : s
}

function paragraphs(file,    s, code, term) {
    while ((getline s < file) > 0) {
        if (code && s !~ /^    / && s != "") {
            print ".EE\n.RE"
            code = 0
        }
        if (s ~ /^@/) {
            paragraphs(folder "/" substr(s, 2))
        } else if (s ~ /^# /) {
            heading(substr(s, 3))
        } else if (s ~ /^= /) {
            print ".TP\n.B " line(substr(s, 3))
            fresh = 1
        } else if (s ~ /^    /) {
            if (!code)
                print (fresh ? "" : ".PP\n") ".RS 4\n.EX"
            print plain(substr(s, 5))
            code = 1
            fresh = 0
        } else if (s == "") {
            gap = 1
        } else {
            if (gap && !fresh)
                print ".PP"
            print line(s)
            fresh = gap = 0
        }
    }
    if (code)
        print ".EE\n.RE"
    close(file)
}

function heading(title) {
    print ".SH " title
    fresh = 1
    gap = 0
}

function describe_option(row,    f, value) {
    split(row, f, "\t")
    value = f[7] != "-" && f[5] == "choice" ? f[7] : f[6]
    gsub(/ /, "|", value)
    print ".TP"
    printf "%s\\fB\\-\\-%s\\fR%s\n", f[3] == "-" ? "" : "\\fB\\-" f[3] "\\fR, ", plain(f[4]),
        value == "-" ? "" : " \\fI" plain(value) "\\fR"
    print line(f[9]) (f[8] == "-" ? "" : ".\nTakes " plain(f[8])) "."
}

function see_also(    i, all) {
    heading("SEE ALSO")
    all = command == "fewray" ? "" : ".BR fewray (1)"
    for (i = 1; i <= name_count; i++)
        if (names[i] != command)
            all = all (all == "" ? "" : ",\n") ".BR fewray\\-" names[i] " (1)"
    print all
}

END {
    page = command == "fewray" ? "fewray" : "fewray-" command
    printf ".TH %s 1 %s \"fewray %s\" \"fewray manual\"\n", toupper(plain(page)), date, version
    heading("NAME")
    print plain(page) " \\- " (command == "fewray" ? "a few paths a pixel to a finished picture" : plain(about[command]))
    heading("SYNOPSIS")
    print command == "fewray" ? ".B fewray\n.I COMMAND\n\\&..." : ".B fewray " command "\n" line(synopsis[command])
    heading("DESCRIPTION")
    if (command != "fewray") {
        print line(text[command])
        fresh = 0
        gap = 1
    }
    paragraphs(folder "/" command ".description.txt")
    if (command == "fewray") {
        heading("COMMANDS")
        for (i = 1; i <= name_count; i++)
            print ".TP\n.BR fewray\\-" names[i] " (1)\n" line(about[names[i]])
    }
    heading("OPTIONS")
    for (i = 1; i <= option_count; i++)
        describe_option(options[i])
    if (command == "fewray")
        print ".TP\n\\fB\\-\\-help\\fR\nlist the commands.\n.TP\n\\fB\\-\\-version\\fR\nprint the version."
    paragraphs(folder "/" command ".txt")
    paragraphs(folder "/every.txt")
    see_also()
}
