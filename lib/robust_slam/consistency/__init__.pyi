from .cliques import max_clique as max_clique
from .pairwise import PcmResult as PcmResult
from .pairwise import pairwise_consistent as pairwise_consistent
from .pairwise import pcm as pcm
