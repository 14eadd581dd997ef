"""stub"""
class Output:
    def __init__(self, io, settings, navigation, gnss, acquisition): self.n=navigation; self.log=[]
    def send(self):
        self.n.fill_solution(); 
    def send_slow(self): pass
    def send_text(self, t): print(t)
    def write_log(self): pass
