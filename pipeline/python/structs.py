#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Makes ctypes of the public headers' structs, so that Python never has another idea of them than C:

    structs.py HEADER.h... > _structs.py

It reads what our headers are written like: structs of plain members, pointers, arrays and function pointers, enums, and
integer #defines for the lengths of arrays. Anything else is an error. tests/adopt/python.sh compares the result with
what the compiler says.
"""

import re
import sys

PLAIN = {"int": "c_int", "float": "c_float", "double": "c_double", "bool": "c_bool", "char": "c_char", "size_t": "c_size_t",
         "ptrdiff_t": "c_ssize_t", "uint8_t": "c_uint8", "uint16_t": "c_uint16", "uint32_t": "c_uint32", "uint64_t": "c_uint64",
         "int32_t": "c_int32", "long long": "c_longlong"}
QUALIFIERS = r"\b(const|volatile)\b"


def declarators(text):
    """The base type and the declarators of one member declaration."""
    text = " ".join(re.sub(QUALIFIERS, " ", text).split())
    match = re.match(r"((?:struct|enum) \w+|long long|\w+) (.*)", text)
    if not match:
        raise ValueError(f"can't be read: {text}")
    return match[1], [d.strip() for d in match[2].split(",")]


def ctype(base, stars, structs):
    if stars:
        return "c_char_p" if (base, stars) == ("char", 1) else "c_void_p"
    if base.startswith("enum "):
        return "c_int"
    if base.startswith("struct "):
        if base[7:] not in structs:
            raise ValueError(f"{base} isn't known yet")
        return base[7:]
    return "C." + PLAIN[base]


def members(body, structs, constants):
    for declaration in filter(None, (d.strip() for d in body.split(";"))):
        function = re.search(r"\(\s*\*\s*(\w+)\s*\)\s*\(", declaration)
        if function:
            yield function[1], "C.c_void_p"
            continue
        base, names = declarators(declaration)
        for name in names:
            stars, name, lengths = re.match(r"([*\s]*)(\w+)((?:\[\w+\])*)$", name).groups()
            kind = ctype(base, stars.count("*"), structs)
            kind = "C." + kind if kind.startswith("c_") else kind
            for length in reversed(re.findall(r"\[(\w+)\]", lengths)):
                kind = f"{kind} * {constants.get(length, length)}"
            yield name, kind


def main():
    structs, constants = {}, {}
    print('# Made of the C headers by structs.py.\nimport ctypes as C\n')
    for path in sys.argv[1:]:
        with open(path, encoding="utf-8") as file:
            text = re.sub(r"/\*.*?\*/", " ", file.read(), flags=re.S)
        constants.update(re.findall(r"#define (\w+)\s+(\d+)\s*$", text, flags=re.M))
        for name, body in re.findall(r"^struct (\w+) \{(.*?)^\};", text, flags=re.S | re.M):
            structs[name] = list(members(body, structs, constants))
            print(f"\nclass {name}(C.Structure):\n    _fields_ = [")
            for member, kind in structs[name]:
                print(f"        ({member!r}, {kind}),")
            print("    ]\n")


if __name__ == "__main__":
    main()
