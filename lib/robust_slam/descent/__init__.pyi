from .damped import levenberg_marquardt as levenberg_marquardt
from .marginals import covariance as covariance
from .marginals import joint_covariance as joint_covariance
from .undamped import gauss_newton as gauss_newton
