# SPDX-License-Identifier: GPL-2.0-or-later
"""`sistap tables`: captures as tables in Parquet files, for questions about months and many machines.

Rows of packets (rows), what the columns are (schema), the folder of tables (store), captures put there (convert). It
may use all rooms but the other products. README.md has the columns, and questions in SQL.
"""
