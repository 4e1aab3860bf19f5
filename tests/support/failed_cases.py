"""Prints the failed cases of Catch2's XML report: name, then file, line, expression, values and messages of the test.

Usage: failed_cases.py REPORT.xml. Long messages are shortened to their ends, because they may contain a page or an
image header.
"""

import sys
import xml.etree.ElementTree as ElementTree

LONGEST = 400  # characters of one value or message
MOST = 10  # assertions of one case


def shortened(text):
    text = " ".join((text or "").split())
    return text if len(text) <= LONGEST else text[: LONGEST // 2] + " ... " + text[-LONGEST // 2 :]


def assertions(case):
    """Returns failed expressions, failures and exceptions of a case and of its sections, in the order of the report."""
    told = []
    of_expressions = {id(thrown) for thrown in case.iterfind(".//Expression/Exception")}
    for element in case.iter():
        if element.tag in ("Info", "Warning"):
            told.append(shortened(element.text))
            continue
        failed = element.tag in ("Failure", "Exception", "FatalErrorCondition") or (
            element.tag == "Expression" and element.get("success") == "false"
        )
        if (element.tag == "Expression" or failed) and id(element) not in of_expressions:
            if failed:
                where = f"{element.get('filename')}:{element.get('line')}: "
                original, expanded = element.find("Original"), element.find("Expanded")
                what = shortened(element.text if original is None else original.text)
                if expanded is not None:
                    what += "  is  " + shortened(expanded.text)
                thrown = element.find("Exception")
                if thrown is not None:
                    what += "  threw  " + shortened(thrown.text)
                yield where + what, told
            told = []


for case in ElementTree.parse(sys.argv[1]).iter("TestCase"):
    result = case.find("OverallResult")
    if result is None or result.get("success") == "true":
        continue
    print(f"  case '{case.get('name')}'")
    for number, (text, told) in enumerate(assertions(case)):
        if number == MOST:
            print("    and more")
            break
        print("    " + text)
        for message in told:
            print("      told: " + message)
