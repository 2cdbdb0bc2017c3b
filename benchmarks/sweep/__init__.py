"""Many graphs, kinds of outliers, rates, seeds and methods: `make sweep`.

``definition`` lists the runs, ``run`` does them, ``journal`` remembers them, and ``summary``
writes the table.
"""
