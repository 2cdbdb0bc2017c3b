from .marginals import covariance as covariance
from .marginals import joint_covariance as joint_covariance
from .minimise import gauss_newton as gauss_newton
from .minimise import levenberg_marquardt as levenberg_marquardt
