"""Equations as the docstrings write them, as MathML: no script, no font to fetch.

``m_1 ẍ_1 = -b_1 ẋ_1 + k (x_2 - x_1)`` is plain text in the models, readable where it
stands.  Here subscripts are set low, names slanted, functions upright; nothing else is
understood, so nothing can be misread: what is no letter or digit is an operator.
"""

import re

from lxml import etree
from lxml.builder import ElementMaker

M = ElementMaker(nsmap={None: "http://www.w3.org/1998/Math/MathML"})
NAME = r"[^\W\d_][^\W\d_\u0300-\u036f]*[\u0300-\u036f]*(?:_\{[^}]*\}|_[\w.*]*\w)*"
TOKEN = re.compile(rf"{NAME}|\d+(?:\.\d+)?(?:e-?\d+)?|<=|>=|\S|\s+")
WORDS = """abs acos and asin atan cos det diag else exp floor for if log max min mod
or otherwise rank round sat sgn sign sin sinh sqrt sum tan tanh then tr where"""
UPRIGHT = frozenset(WORDS.split())
RAISED = {"²": "2", "³": "3", "⁴": "4", "⁺": "+", "⁻": "−"}
SIGNS = {"-": "−", "*": "·", "<=": "≤", ">=": "≥"}


def equation(line: str) -> str:
    """Return one line of plain-text mathematics as a ``<math>`` element."""
    row = M.mrow()
    for token in TOKEN.findall(line.strip()):
        _put(row, token)
    return etree.tostring(M.math(row, displaystyle="true"), encoding="unicode")


def _put(row: etree._Element, token: str) -> None:
    """Append one token to a row; a raised one goes onto what stands before it."""
    if token.isspace():
        row.append(M.mspace(width="1.5em" if len(token) > 1 else "0.25em"))
    elif token in RAISED and len(row) and row[-1].tag != "mspace":
        base = row[-1]
        row.remove(base)
        row.append(M.msup(base, M.mo(RAISED[token])))
    elif token[0].isdigit():
        row.append(M.mn(token))
    elif token[0].isalpha():
        row.append(_name(token))
    else:
        row.append(M.mo(SIGNS.get(token, token), stretchy="false"))


def _name(token: str) -> etree._Element:
    """Return ``omega_n1`` with its subscript, a function or word upright."""
    letter, _, low = token.partition("_")
    plain = letter in UPRIGHT or (len(letter) > 3 and not low)
    symbol = M.mi(letter, **({"mathvariant": "normal"} if plain else {}))
    if not low:
        return symbol
    return M.msub(symbol, M.mi(low.strip("{}").replace("_", ","), mathvariant="normal"))
