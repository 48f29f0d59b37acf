"""The page of one wall, that `rockdamp assess --report` writes; the report of all studies does not read it."""
