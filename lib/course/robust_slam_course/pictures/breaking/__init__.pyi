from .picture import breaking as breaking
