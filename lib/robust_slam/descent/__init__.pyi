from .damped import levenberg_marquardt as levenberg_marquardt
from .undamped import gauss_newton as gauss_newton
