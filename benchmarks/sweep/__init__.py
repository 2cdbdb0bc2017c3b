"""Many graphs, kinds of outliers, rates, seeds and methods: `make sweep`.

``definition`` lists the runs, ``run`` does those of one world, ``execute`` says who does them,
``journal`` remembers them, and ``summary`` writes the table.
"""
