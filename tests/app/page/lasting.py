"""Elements of a page that are found again where the page draws them anew between finding and use, as views do."""

from selenium.common import StaleElementReferenceException
from selenium.webdriver import Chrome
from selenium.webdriver.remote.webelement import WebElement


class Element(WebElement):
    """An element with the way to it."""

    def __init__(self, found, place):
        super().__init__(found.parent, found.id)
        self._place = place

    def _execute(self, command, params=None):
        return self._again(lambda: super(Element, self)._execute(command, params))

    def is_displayed(self):
        return self._again(super().is_displayed)

    def _again(self, ask):
        try:
            return ask()
        except StaleElementReferenceException:
            self._id = self.parent.find_element(*self._place).id
            return ask()


class Driver(Chrome):
    """A browser that finds such elements."""

    def find_element(self, by="id", value=None):
        return Element(super().find_element(by, value), (by, value))
