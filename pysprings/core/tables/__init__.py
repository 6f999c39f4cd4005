# SPDX-License-Identifier: MIT
"""Tables that people bring, as CSV text or Excel workbooks: one reader for layers, loads, springs, sequences, studies.

`files` turns a file into sheets of cells, `cells` a cell into a number, `headings` a heading into a column and its
unit, `table` a sheet into the columns that a caller declares. Whatever can be read in two ways is refused with its
place.
"""

from pysprings.core.tables.files import ENDINGS, Sheet, is_table, sheets_of
from pysprings.core.tables.headings import GRAVITY, Column, split
from pysprings.core.tables.table import Faults, Table, TableNote, keyed_table, one_table, tables_of

__all__ = [
    "ENDINGS", "GRAVITY", "Column", "Faults", "Sheet", "Table", "TableNote", "is_table", "keyed_table", "one_table",
    "sheets_of", "split", "tables_of",
]  # fmt: skip
